// Adam on the device. A coordinate is a parameter or its logarithm; `indices` says which, as in `params.cu`,
// with the highest bit set for a logarithm.

#define LOGARITHM 0x80000000u

DEVICE double slope_of(const float* gradient, const float* params, u32 index) {
    u32 at = index & ~LOGARITHM;
    double slope = gradient[at];
    // d / d ln p = p d / d p.
    return index & LOGARITHM ? slope * (double)params[at] : slope;
}

// Sums of squares of d loss / d theta, one number a block, of gradient `blockIdx.y`.
extern "C" __global__ void __launch_bounds__(THREADS) square_lengths(
    double* out, const float* const* gradients, const float* params, const u32* indices, u32 count
) {
    __shared__ double partial[THREADS / 32];
    const float* gradient = gradients[blockIdx.y];
    double sum = 0.0;
    for (u32 i = blockIdx.x * THREADS + threadIdx.x; i < count; i += gridDim.x * THREADS) {
        double slope = slope_of(gradient, params, indices[i]);
        sum += slope * slope;
    }
    for (int mask = 16; mask > 0; mask /= 2) sum += __shfl_xor_sync(0xffffffffu, sum, mask);
    if (threadIdx.x % 32 == 0) partial[threadIdx.x / 32] = sum;
    __syncthreads();
    if (threadIdx.x == 0) {
        double total = 0.0;
        for (u32 w = 0; w < THREADS / 32; w++) total += partial[w];
        out[blockIdx.y * gridDim.x + blockIdx.x] = total;
    }
}

// The weighted sum of gradients by theta; `finite` is cleared if a component is not.
extern "C" __global__ void weigh_gradients(
    double* sums, u32* finite, const float* const* gradients, const double* weights, u32 waiting,
    const float* params, const u32* indices, u32 count
) {
    u32 i = blockIdx.x * THREADS + threadIdx.x;
    if (i >= count) return;
    double sum = 0.0;
    for (u32 g = 0; g < waiting; g++)
        sum += weights[g] * slope_of(gradients[g], params, indices[i]);
    sums[i] = sum;
    if (!isfinite(sum)) *finite = 0;
}

// One step of Adam down that sum, and back to the start by a share of the way; parameters follow.
extern "C" __global__ void step_adam(
    double* theta, double* first, double* second, const double* sums, const double* rates,
    const double2* bounds, const double* start, double back, double rate, double beta1, double beta2, double unbias1, double unbias2,
    double epsilon, float* params, const u32* indices, u32 count, u32 angles, u32 angles_end
) {
    u32 i = blockIdx.x * THREADS + threadIdx.x;
    if (i >= count) return;
    double g = sums[i];
    double m = first[i] = beta1 * first[i] + (1.0 - beta1) * g;
    double v = second[i] = beta2 * second[i] + (1.0 - beta2) * g * g;
    double step = rates[i] * rate * (m / unbias1) / (sqrt(v / unbias2) + epsilon);
    double x = theta[i] - step - back * (theta[i] - start[i]);
    x = fmin(fmax(x, bounds[i].x), bounds[i].y);
    theta[i] = x;
    u32 index = indices[i], at = index & ~LOGARITHM;
    float value = (float)(index & LOGARITHM ? exp(x) : x);
    // Rounding must not carry an angle above pi.
    if (at >= angles && at < angles_end) value = fminf(value, 3.14159274f);
    params[at] = value;
}
