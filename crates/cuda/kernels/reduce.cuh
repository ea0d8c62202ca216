// Sums and maxima over the threads of a small kernel's block; every thread gets them.

DEVICE double block_sum(double value) {
    __shared__ double partial[THREADS / 32];
    for (int mask = 16; mask > 0; mask /= 2) value += __shfl_xor_sync(0xffffffffu, value, mask);
    __syncthreads();
    if (threadIdx.x % 32 == 0) partial[threadIdx.x / 32] = value;
    __syncthreads();
    double sum = 0.0;
    for (u32 w = 0; w < THREADS / 32; w++) sum += partial[w];
    return sum;
}

DEVICE float block_max(float value) {
    __shared__ float partial[THREADS / 32];
    for (int mask = 16; mask > 0; mask /= 2)
        value = fmaxf(value, __shfl_xor_sync(0xffffffffu, value, mask));
    __syncthreads();
    if (threadIdx.x % 32 == 0) partial[threadIdx.x / 32] = value;
    __syncthreads();
    for (u32 w = 0; w < THREADS / 32; w++) value = fmaxf(value, partial[w]);
    return value;
}
