// Adam on the device, with one second moment a kind of parameter. A coordinate is a parameter or its logarithm; `indices` has its parameter, as
// in `params.cu`, with the highest bit set for a logarithm.

#define LOGARITHM 0x80000000u

DEVICE double coordinate_gradient(const float* gradient, const float* params, u32 index) {
    u32 at = index & ~LOGARITHM;
    double component = gradient[at];
    // d / d ln p = p d / d p.
    return index & LOGARITHM ? component * (double)params[at] : component;
}

struct SquareLengthsArgs {
    double* out;                    // [gradients][blocks]
    const float* const* gradients;
    const float* params;
    const u32* indices;             // [count]
    u32 count;                      // coordinates
    u32 pad;
};

// Sums of squares of d loss / d theta, one number a block, of gradient `blockIdx.y`.
extern "C" __global__ void __launch_bounds__(THREADS)
square_lengths(const __grid_constant__ SquareLengthsArgs args) {
    __shared__ double partial[THREADS / 32];
    const float* gradient = args.gradients[blockIdx.y];
    double sum = 0.0;
    for (u32 i = blockIdx.x * THREADS + threadIdx.x; i < args.count; i += gridDim.x * THREADS) {
        double component = coordinate_gradient(gradient, args.params, args.indices[i]);
        sum += component * component;
    }
    for (int mask = 16; mask > 0; mask /= 2) sum += __shfl_xor_sync(0xffffffffu, sum, mask);
    if (threadIdx.x % 32 == 0) partial[threadIdx.x / 32] = sum;
    __syncthreads();
    if (threadIdx.x == 0) {
        double total = 0.0;
        for (u32 w = 0; w < THREADS / 32; w++) total += partial[w];
        args.out[blockIdx.y * gridDim.x + blockIdx.x] = total;
    }
}

struct WeighGradientsArgs {
    double* sums;                   // [count]
    u32* finite;
    const float* const* gradients;  // [gradient_count]
    const double* weights;          // [gradient_count]
    const float* params;
    const u32* indices;             // [count]
    u32 gradient_count;
    u32 count;                      // coordinates
};

// The weighted sum of gradients by theta; `finite` is cleared if a component is not.
extern "C" __global__ void weigh_gradients(const __grid_constant__ WeighGradientsArgs args) {
    u32 i = blockIdx.x * THREADS + threadIdx.x;
    if (i >= args.count) return;
    double sum = 0.0;
    for (u32 g = 0; g < args.gradient_count; g++)
        sum +=
            args.weights[g] * coordinate_gradient(args.gradients[g], args.params, args.indices[i]);
    args.sums[i] = sum;
    if (!isfinite(sum)) *args.finite = 0;
}

struct MeanSquaresArgs {
    double* second;         // [kinds]: second moments
    const double* sums;     // [count]: the weighted gradient
    const u32* starts;      // [kinds + 1]: first coordinate of each kind, and their number
    double beta2;
};

// Second moments after a step: one per kind of parameter, of its gradient's mean square. A block a
// kind.
extern "C" __global__ void __launch_bounds__(THREADS)
mean_squares(const __grid_constant__ MeanSquaresArgs args) {
    u32 first = args.starts[blockIdx.x], end = args.starts[blockIdx.x + 1];
    double sum = 0.0;
    for (u32 i = first + threadIdx.x; i < end; i += THREADS) sum += args.sums[i] * args.sums[i];
    sum = block_sum(sum);
    if (threadIdx.x > 0) return;
    double mean = sum / (double)max(end - first, 1u);
    double* v = &args.second[blockIdx.x];
    *v = args.beta2 * *v + (1.0 - args.beta2) * mean;
}

struct StepAdamArgs {
    double* theta;          // [count]: coordinates
    double* first;          // [count]: first moments
    const double* second;   // [kinds]: second moments after this step
    const double* sums;     // [count]: the weighted gradient
    const u32* kinds;       // [count]: kind of each coordinate
    const double* rates;    // [count]: step sizes relative to `rate`
    const double2* bounds;  // [count]: least and largest value
    const double* start;    // [count]: coordinates that `back` pulls towards
    float* params;
    const u32* indices;     // [count]
    double back;            // share of the distance back to `start`
    double rate;
    double beta1;
    double unbias1, unbias2;
    double slope;           // gradient over its kind's size becomes a step by it, up to 1
    double epsilon;
    u32 count;              // coordinates
    u32 angles, angles_end; // parameters that are rest angles
    u32 pad;
};

// One step of Adam down that sum, and back to the start by a share of the distance; parameters
// follow.
extern "C" __global__ void step_adam(const __grid_constant__ StepAdamArgs args) {
    u32 i = blockIdx.x * THREADS + threadIdx.x;
    if (i >= args.count) return;
    const double beta1 = args.beta1;
    double m = args.first[i] = beta1 * args.first[i] + (1.0 - beta1) * args.sums[i];
    double size = sqrt(args.second[args.kinds[i]] / args.unbias2) + args.epsilon;
    double step = fmin(fmax(args.slope * (m / args.unbias1) / size, -1.0), 1.0);
    double x = args.theta[i] - args.rate * args.rates[i] * step - args.back * (args.theta[i] - args.start[i]);
    x = fmin(fmax(x, args.bounds[i].x), args.bounds[i].y);
    args.theta[i] = x;
    u32 index = args.indices[i], at = index & ~LOGARITHM;
    float value = (float)(index & LOGARITHM ? exp(x) : x);
    // Rounding must not carry an angle above pi.
    if (at >= args.angles && at < args.angles_end) value = fminf(value, 3.14159274f);
    args.params[at] = value;
}
