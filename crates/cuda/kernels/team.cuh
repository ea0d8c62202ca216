// A team of BLOCKS blocks simulates INSTANCES instances together. How its blocks meet and how a node's
// new values reach the blocks that have it in their halo depends on the SHAPE of the launch:
//
// - SHAPE_BLOCK: one block; its barrier is all there is.
// - SHAPE_CLUSTER: owners write into the halos through distributed shared memory; a cluster barrier.
// - SHAPE_GRID: owners write to global memory, a barrier of the grid, then halos are read from there.

#define SHAPE_BLOCK 0
#define SHAPE_CLUSTER 1
#define SHAPE_GRID 2

extern __shared__ float4 shared_memory[];

DEVICE u32 shared_address(const void* p) { return (u32)__cvta_generic_to_shared(p); }

// The same place in another block of the cluster.
DEVICE u32 remote_address(const void* here, u32 block) {
    u32 there;
    asm("mapa.shared::cluster.u32 %0, %1, %2;"
        : "=r"(there)
        : "r"(shared_address(here)), "r"(block));
    return there;
}
DEVICE void store_remote(const float4* here, u32 block, float4 value) {
    asm volatile("st.shared::cluster.v4.f32 [%0], {%1, %2, %3, %4};" ::"r"(
                     remote_address(here, block)),
                 "f"(value.x), "f"(value.y), "f"(value.z), "f"(value.w)
                 : "memory");
}
DEVICE void store_remote(const float2* here, u32 block, float2 value) {
    asm volatile("st.shared::cluster.v2.f32 [%0], {%1, %2};" ::"r"(remote_address(here, block)),
                 "f"(value.x), "f"(value.y)
                 : "memory");
}

// All threads of the team meet; what they wrote before, to shared and to global memory, is visible
// after (global memory through `__ldcg`). `round` counts the meetings of a grid.
DEVICE void meet(u32* counter, u32& round) {
#if SHAPE == SHAPE_BLOCK
    __syncthreads();
#elif SHAPE == SHAPE_CLUSTER
    asm volatile("barrier.cluster.arrive.release.aligned;" ::: "memory");
    asm volatile("barrier.cluster.wait.acquire.aligned;" ::: "memory");
#else
    __syncthreads();
    round += BLOCKS;
    if (threadIdx.x == 0) {
        __threadfence();
        atomicAdd(counter, 1u);
        u32 seen;
        do {
            asm volatile("ld.acquire.gpu.u32 %0, [%1];" : "=r"(seen) : "l"(counter) : "memory");
        } while (seen < round);
        __threadfence();
    }
    __syncthreads();
#endif
}

// Copies from global to shared memory in the background.
DEVICE void copy_async(float4* to, const float4* from) {
    asm volatile("cp.async.cg.shared.global [%0], [%1], 16;" ::"r"(shared_address(to)), "l"(from)
                 : "memory");
}
DEVICE void copy_async(float2* to, const float2* from) {
    asm volatile("cp.async.ca.shared.global [%0], [%1], 8;" ::"r"(shared_address(to)), "l"(from)
                 : "memory");
}
DEVICE void wait_for_copies() { asm volatile("cp.async.wait_all;" ::: "memory"); }
