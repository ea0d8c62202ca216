// A team of BLOCKS blocks simulates INSTANCES instances together. The SHAPE of the launch decides
// how its blocks synchronize and how a node's new values reach the blocks that have it in their
// halo:
//
// - SHAPE_BLOCK: one block; its barrier suffices.
// - SHAPE_CLUSTER: owners write into the halos through distributed shared memory. A block waits for
//   the bytes of its halo, not for the others: a barrier of the cluster that also orders memory
//   would wait for all writes anywhere, tapes included. Contact needs such a
//   barrier, since it goes through global memory.
// - SHAPE_GRID: owners write to global memory, a barrier of the grid, then halos are read from
//   there.

#define SHAPE_BLOCK 0
#define SHAPE_CLUSTER 1
#define SHAPE_GRID 2

#define COUNTS_BYTES (SHAPE == SHAPE_CLUSTER && !CONTACT)

extern __shared__ float4 shared_memory[];

DEVICE u32 shared_address(const void* p) { return (u32)__cvta_generic_to_shared(p); }

// The same place in another block of the cluster.
DEVICE u32 remote_address(u32 here, u32 block) {
    u32 there;
    asm("mapa.shared::cluster.u32 %0, %1, %2;" : "=r"(there) : "r"(here), "r"(block));
    return there;
}
// Writes into another block's halo, whose bytes are counted by the barrier `arrivals`.
DEVICE void send(const float4* here, u32 arrivals, u32 block, float4 value) {
    u32 there = remote_address(shared_address(here), block);
#if COUNTS_BYTES
    asm volatile(
        "st.async.weak.shared::cluster.mbarrier::complete_tx::bytes.v4.f32 [%0], {%1, %2, %3, %4}, "
        "[%5];"
        ::"r"(there), "f"(value.x), "f"(value.y), "f"(value.z), "f"(value.w),
        "r"(remote_address(arrivals, block))
        : "memory"
    );
#else
    asm volatile("st.shared::cluster.v4.f32 [%0], {%1, %2, %3, %4};" ::"r"(there), "f"(value.x),
                 "f"(value.y), "f"(value.z), "f"(value.w)
                 : "memory");
#endif
}
DEVICE void send(const float2* here, u32 arrivals, u32 block, float2 value) {
    u32 there = remote_address(shared_address(here), block);
#if COUNTS_BYTES
    asm volatile(
        "st.async.weak.shared::cluster.mbarrier::complete_tx::bytes.v2.f32 [%0], {%1, %2}, [%3];"
        ::"r"(there), "f"(value.x), "f"(value.y), "r"(remote_address(arrivals, block))
        : "memory"
    );
#else
    asm volatile("st.shared::cluster.v2.f32 [%0], {%1, %2};" ::"r"(there), "f"(value.x),
                 "f"(value.y)
                 : "memory");
#endif
}

// Barriers that count the bytes of a block's halo, one for each buffer; bytes may come before they
// are expected. A buffer is written to again only by blocks that have received from this one since:
// a block that reads a node of another block's does so for own nodes that are in the other's halo,
// and sends them after all that it reads for them (`src/plan/layout/tests/halos.rs`).
struct Arrivals {
    u32 address;  // of the first; the other is 8 bytes on
    u32 bytes;    // of a halo
    u32 phases;   // a bit for each: the phase that is waited for
    DEVICE_MEMBER u32 of(u32 buffer) const { return address + 8 * buffer; }
};

// To be called before the team's first barrier.
DEVICE Arrivals count_bytes(u32 bytes) {
    Arrivals a = {0, bytes, 0};
#if COUNTS_BYTES
    __shared__ u64 barriers[2];
    a.address = shared_address(barriers);
    if (threadIdx.x == 0) {
        asm volatile("mbarrier.init.shared::cta.b64 [%0], 1;" ::"r"(a.of(0)) : "memory");
        asm volatile("mbarrier.init.shared::cta.b64 [%0], 1;" ::"r"(a.of(1)) : "memory");
        asm volatile("fence.mbarrier_init.release.cluster;" ::: "memory");
    }
#endif
    return a;
}

// A halo will be written to a buffer.
DEVICE void expect_halo(const Arrivals& a, u32 buffer) {
#if COUNTS_BYTES
    if (threadIdx.x == 0)
        asm volatile("mbarrier.arrive.expect_tx.shared::cta.b64 _, [%0], %1;" ::"r"(a.of(buffer)),
                     "r"(a.bytes)
                     : "memory");
#endif
}

// Barrier of all threads of the team; their earlier writes to shared and global memory are
// visible after (global memory through `__ldcg`). `round` counts the arrivals of a grid's blocks.
DEVICE void synchronize_team(u32* counter, u32& round) {
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

// Barrier of the block; after it, what the other blocks have sent to a buffer has arrived.
DEVICE void synchronize_halo(Arrivals& a, u32 buffer, u32* counter, u32& round) {
#if COUNTS_BYTES
    __syncthreads();
    asm volatile(
        "{\n"
        ".reg .pred done;\n"
        "AGAIN:\n"
        "mbarrier.try_wait.parity.acquire.cluster.shared::cta.b64 done, [%0], %1;\n"
        "@done bra DONE;\n"
        "bra AGAIN;\n"
        "DONE:\n"
        "}" ::"r"(a.of(buffer)),
        "r"(a.phases >> buffer & 1)
        : "memory");
    a.phases ^= 1u << buffer;
#else
    synchronize_team(counter, round);
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
