// Blocks of threads on the processor: the CUDA branch of loops.cu as it is, with threads in place of those of a GPU.
#include <atomic>
#include <barrier>
#include <cmath>
#include <memory>
#include <thread>
#include <vector>
struct Dim { unsigned x; };
static thread_local Dim threadIdx, blockIdx; static Dim blockDim, gridDim;
static std::vector<std::unique_ptr<std::barrier<>>> block_barriers, warp_barriers;
static std::vector<std::vector<double>> lanes, shared_memory;
static void __syncthreads() { block_barriers[blockIdx.x]->arrive_and_wait(); }
static double __shfl_xor_sync(unsigned, double v, int d) {
    auto& all = lanes[blockIdx.x]; const unsigned w = blockIdx.x * (blockDim.x / 32) + threadIdx.x / 32;
    all[threadIdx.x] = v; warp_barriers[w]->arrive_and_wait();
    const double other = all[threadIdx.x ^ d]; warp_barriers[w]->arrive_and_wait(); return other;
}
static void __threadfence() { std::atomic_thread_fence(std::memory_order_seq_cst); }
static unsigned atomicAdd(unsigned* p, unsigned v) { return __atomic_fetch_add(p, v, __ATOMIC_SEQ_CST); }
#define __global__
#define __device__
#define __launch_bounds__(...)
#include "loops_emulated.cu"
template <class F> static void grid(unsigned blocks, unsigned threads, F run) {
    blockDim.x = threads; gridDim.x = blocks; block_barriers.clear(); warp_barriers.clear();
    lanes.assign(blocks, std::vector<double>(threads)); shared_memory.assign(blocks, std::vector<double>(32 * 16));
    for (unsigned b = 0; b < blocks; ++b) {
        block_barriers.push_back(std::make_unique<std::barrier<>>(threads));
        for (unsigned w = 0; w < threads / 32; ++w) warp_barriers.push_back(std::make_unique<std::barrier<>>(32));
    }
    std::vector<std::thread> all;
    for (unsigned b = 0; b < blocks; ++b) for (unsigned t = 0; t < threads; ++t)
        all.emplace_back([=] { blockIdx.x = b; threadIdx.x = t; run(); });
    for (auto& t : all) t.join();
}
#include <cstdio>
#include <random>
int main() {
    const Index n = 5000; std::mt19937 random(1); std::uniform_real_distribution<double> u(-1, 1);
    std::vector<double> p(n), g(n), h(n), a(n), w(2 + 2 * 8 * 16), out(16);
    double worst = 0;
    for (int trial_ = 0; trial_ < 6; ++trial_) {
        const unsigned blocks = 1 + trial_ % 4, threads = 32 << trial_ % 3;
        for (Index i = 0; i < n; ++i) { const double v = u(random); p[i] = v > 0 ? v : 0; g[i] = u(random); h[i] = u(random); }
        double sum = 0, cells = 0; for (double v : p) { sum += v; cells += v > 0; }
        // the projection: Newton's steps of the whole grid
        std::vector<double> q = p; const double load = 0.3 * sum;
        grid(blocks, threads, [&] { project(n, n, q.data(), load, sum, cells, 1e-15, g.data(), h.data(), w.data(), out.data()); });
        double carried = 0, slope = 0; for (Index i = 0; i < n; ++i) { carried += q[i]; slope += h[i] * (q[i] - g[i]); }
        worst = std::fmax(worst, std::fmax(std::fabs(carried / load - 1), std::fabs(slope - out[0]) / n));
        std::vector<double> height(n);
        grid(blocks, threads, [&] { gap(n, n, g.data(), h.data(), p.data(), NAN, INFINITY, height.data(), w.data(), out.data()); });
        double m = 0, c = 0, big = 0; for (Index i = 0; i < n; ++i) { if (p[i] > 0) { m += g[i] + h[i]; ++c; } big = std::fmax(big, std::fabs(h[i])); }
        worst = std::fmax(worst, std::fmax(std::fabs(m / c - out[0]), std::fabs(big - out[6])));
        worst = std::fmax(worst, std::fabs(out[2] - sum) / sum);
    }
    std::printf("worst %.1e\n", worst); return worst < 1e-12 ? 0 : 1;
}
