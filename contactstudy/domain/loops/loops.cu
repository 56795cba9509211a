// Loops over fields on a GPU, those of compiled.py: one launch each, whose sums are taken over the whole grid.
//
// REAL is the type of an iteration's fields, PRE that of its preconditioner's. `work` holds a barrier and the sums of
// each block of threads; `out`, memory of the host, takes the totals. Sums are taken in the same order every time.
// With SERIAL a C++ compiler makes functions of one thread, for tests without a GPU.

typedef long long Index;

// Cells of the first field, and those of one of its rows.
#define FIELD Index cells, Index columns

#ifdef SERIAL
#include <cmath>
#define KERNEL extern "C" void
#define CELLS(n) for (Index i = 0; i < (n); ++i)
#define IS_FIRST true
template <int SUMS, int MAXIMA> void total(double (&)[SUMS + MAXIMA], double*, int = 0) {}
#else
#define KERNEL extern "C" __global__ void __launch_bounds__(512, 2)
#define CELLS(n) \
    for (Index i = blockIdx.x * (Index)blockDim.x + threadIdx.x; i < (n); i += (Index)gridDim.x * blockDim.x)
#define IS_FIRST (blockIdx.x == 0 && threadIdx.x == 0)

__device__ inline double joined(bool sum, double a, double b) { return sum ? a + b : (b > a ? b : a); }

template <int SUMS, int MAXIMA> __device__ void total_of_block(double (&v)[SUMS + MAXIMA]) {
    __shared__ double parts[SUMS + MAXIMA][32];
    for (int k = 0; k < SUMS + MAXIMA; ++k) {
        for (int d = 16; d; d /= 2) v[k] = joined(k < SUMS, v[k], __shfl_xor_sync(~0u, v[k], d));
        if (threadIdx.x % 32 == 0) parts[k][threadIdx.x / 32] = v[k];
    }
    __syncthreads();
    for (int k = 0; k < SUMS + MAXIMA; ++k) {
        v[k] = parts[k][0];
        for (int w = 1; w < blockDim.x / 32; ++w) v[k] = joined(k < SUMS, v[k], parts[k][w]);
    }
    __syncthreads();
}

// All blocks run at once: the launch is cooperative.
__device__ void barrier(double* work) {
    volatile unsigned* state = (volatile unsigned*)work;  // blocks that wait, and barriers passed
    __syncthreads();
    if (threadIdx.x == 0) {
        const unsigned passed = state[1];
        __threadfence();
        if (atomicAdd((unsigned*)state, 1u) == gridDim.x - 1) {
            state[0] = 0;
            __threadfence();
            state[1] = passed + 1;
        } else {
            while (state[1] == passed) {}
        }
        __threadfence();
    }
    __syncthreads();
}

// Sums, and maxima of numbers at least 0, over all threads, for all of them; two in a row take an even and an odd `turn`.
template <int SUMS, int MAXIMA> __device__ void total(double (&v)[SUMS + MAXIMA], double* work, int turn = 0) {
    constexpr int N = SUMS + MAXIMA;
    total_of_block<SUMS, MAXIMA>(v);
    volatile double* parts = work + 2 + turn % 2 * gridDim.x * N;
    if (threadIdx.x == 0)
        for (int k = 0; k < N; ++k) parts[blockIdx.x * N + k] = v[k];
    barrier(work);
    for (int k = 0; k < N; ++k) {
        v[k] = 0;
        for (int b = threadIdx.x; b < gridDim.x; b += blockDim.x) v[k] = joined(k < SUMS, v[k], parts[b * N + k]);
    }
    total_of_block<SUMS, MAXIMA>(v);
}
#endif

template <int N>
#ifndef SERIAL
__device__
#endif
inline void give(const double (&v)[N], double* out, int begin = 0) {
    if (IS_FIRST)
        for (int k = 0; k < N; ++k) out[begin + k] = v[k];
}

// Gap, counted from `approach`, or where that is nan from the mean height over the active set.
KERNEL gap(FIELD, const REAL* undeformed, const REAL* displacement, const REAL* pressure, double approach,
           double limit, REAL* height, double* work, double* out) {
    double mean[2] = {0, 0};
    if (approach != approach) {
        CELLS(cells) if (pressure[i] > 0 && pressure[i] < limit) {
            mean[0] += undeformed[i] + displacement[i];
            mean[1] += 1;
        }
        total<2, 0>(mean, work);
        approach = mean[0] / mean[1];
    }
    // load, moment and load of the active set; largest violation and displacement
    double v[5] = {0, 0, 0, 0, 0};
    CELLS(cells) {
        const REAL loaded = pressure[i], deflection = displacement[i];
        const REAL distance = undeformed[i] + deflection - approach;
        height[i] = distance;
        const bool empty = loaded == 0, full = loaded >= limit;
        const double active = empty || full ? 0 : loaded;
        v[0] += loaded;
        v[1] += active * fabs((double)distance);
        v[2] += active;
        const double violation = empty ? -distance : full ? distance : REAL(0);
        v[3] = violation > v[3] ? violation : v[3];
        v[4] = fabs((double)deflection) > v[4] ? fabs((double)deflection) : v[4];
    }
    total<3, 2>(v, work, 1);
    const double first[2] = {approach, mean[1]};
    give(first, out);
    give(v, out, 2);
}

KERNEL active_set(FIELD, const REAL* pressure, const REAL* height, double limit, PRE* active, PRE* active_gap,
                  double* work, double* out) {
    CELLS(cells) {
        const bool inside = pressure[i] > 0 && pressure[i] < limit;
        active[i] = inside;
        active_gap[i] = inside ? height[i] : REAL(0);
    }
}

KERNEL add_entering(FIELD, const REAL* pressure, const REAL* height, const PRE* extended, double step_length,
                    double limit, PRE* active, PRE* active_gap, double* work, double* out) {
    double count[1] = {0};
    CELLS(cells) {
        const double loaded = pressure[i], expected = height[i] - step_length * extended[i];
        if ((loaded == 0 && expected < 0) || (loaded >= limit && expected > 0)) {
            count[0] += 1;
            active[i] = 1;
            active_gap[i] = height[i];
        }
    }
    total<1, 0>(count, work);
    give(count, out);
}

KERNEL direction_sums(FIELD, const REAL* active, const REAL* preconditioned, double* work, double* out) {
    double v[2] = {0, 0};
    CELLS(cells) {
        v[0] += active[i];
        v[1] += preconditioned[i];
    }
    total<2, 0>(v, work);
    give(v, out);
}

KERNEL conjugacy_sums(FIELD, const REAL* height, const PRE* preconditioned, const PRE* active, const REAL* before,
                      const REAL* after, const REAL* displacement_before, const REAL* displacement_after, double* work,
                      double* out) {
    double v[7] = {0, 0, 0, 0, 0, 0, 0};
    CELLS(cells) {
        const double inside = active[i], residual = preconditioned[i], distance = height[i];
        const double step = inside * (after[i] - before[i]), response = displacement_after[i] - displacement_before[i];
        v[0] += inside;
        v[1] += residual;
        v[2] += distance * residual;
        v[3] += residual * response;
        v[4] += inside * response;
        v[5] += distance * step;
        v[6] += step;
    }
    total<7, 0>(v, work);
    give(v, out);
}

// Number of cells cut off, load, loaded cells, slope; largest pressure.
KERNEL trial(FIELD, const REAL* pressure, const REAL* height, const PRE* preconditioned, const PRE* active,
             double shift, double beta, double step_length, double limit, REAL* buffer, double* work, double* out) {
    double v[5] = {0, 0, 0, 0, 0};
    CELLS(cells) {
        double direction = shift - preconditioned[i];
        if (beta != 0) direction += beta * (pressure[i] - buffer[i]);
        const double change = direction * active[i] * step_length;
        double after = pressure[i] + change;
        v[3] += height[i] * change;
        v[0] += after < 0 || after > limit;
        after = after <= 0 ? 0 : after;
        buffer[i] = after;
        v[1] += after;
        v[2] += after > 0;
        v[4] = after > v[4] ? after : v[4];
    }
    total<4, 1>(v, work);
    give(v, out);
}

// Shift, cut off at zero and multiply a pressure to the `load`, see `shift_to_load`; the slope along the step to it.
KERNEL project(FIELD, REAL* trial, double load, double current_load, double loaded_cells, double rounding,
               const REAL* pressure, const REAL* height, double* work, double* out) {
    double shift = 0, before = -1;
    int turn = 0;
    for (; current_load > load && loaded_cells != before; ++turn) {
        shift += (current_load - load) / loaded_cells;
        before = loaded_cells;
        double v[2] = {0, 0};
        CELLS(cells) {
            const double shifted = trial[i] - shift;
            v[0] += shifted > 0 ? shifted : 0;
            v[1] += shifted > 0;
        }
        total<2, 0>(v, work, turn);
        current_load = v[0];
        loaded_cells = v[1];
    }
    const double factor = fabs(current_load / load - 1) <= rounding ? 1 : load / current_load;
    double slope[1] = {0};
    CELLS(cells) {
        const double shifted = trial[i] - shift;
        const REAL after = (shifted <= 0 ? 0 : shifted) * factor;
        trial[i] = after;
        slope[0] += (double)height[i] * (after - pressure[i]);
    }
    total<1, 0>(slope, work, turn);
    give(slope, out);
}

KERNEL slope(FIELD, const REAL* trial, const REAL* pressure, const REAL* height, double* work, double* out) {
    double v[1] = {0};
    CELLS(cells) v[0] += (double)height[i] * (trial[i] - pressure[i]);
    total<1, 0>(v, work);
    give(v, out);
}

KERNEL curvature(FIELD, const REAL* trial, const REAL* pressure, const REAL* trial_displacement,
                 const REAL* displacement, double* work, double* out) {
    double v[1] = {0};
    CELLS(cells) v[0] += ((double)trial[i] - pressure[i]) * ((double)trial_displacement[i] - displacement[i]);
    total<1, 0>(v, work);
    give(v, out);
}

KERNEL outside_limits(FIELD, const REAL* trial, const REAL* pressure, double factor, double limit, double* work,
                      double* out) {
    double count[1] = {0};
    CELLS(cells) {
        const double after = pressure[i] + factor * (trial[i] - pressure[i]);
        count[0] += after < 0 || after > limit;
    }
    total<1, 0>(count, work);
    give(count, out);
}

KERNEL take_fraction(FIELD, REAL* trial, const REAL* pressure, REAL* trial_displacement, const REAL* displacement,
                     double fraction, double limit, double* work, double* out) {
    CELLS(cells) {
        const double after = pressure[i] + fraction * (trial[i] - pressure[i]);
        trial[i] = after < 0 ? 0 : after > limit ? limit : after;
        trial_displacement[i] = displacement[i] + fraction * (trial_displacement[i] - displacement[i]);
    }
}

// Complex `waves` times real `factors`, one for each wave, and `scale`; `cells` are numbers, two for each wave.
KERNEL scale(FIELD, REAL* waves, const REAL* factors, double scale, double* work, double* out) {
    CELLS(cells / 2) {
        const REAL factor = factors[i] * scale;
        waves[2 * i] *= factor;
        waves[2 * i + 1] *= factor;
    }
}

KERNEL differences(FIELD, const REAL* first, const REAL* second, double* work, double* out) {
    double count[1] = {0};
    CELLS(cells) count[0] += first[i] != second[i];
    total<1, 0>(count, work);
    give(count, out);
}

// Cells inside the active set, and sides between one inside and one outside.
KERNEL sides(FIELD, const REAL* active, double* work, double* out) {
    const unsigned n = columns;
    double v[2] = {0, 0};
    CELLS(cells) {
        const bool inside = active[i] > 0;
        v[0] += inside;
        if (i >= n) v[1] += inside != (active[i - n] > 0);
        if ((unsigned)i % n) v[1] += inside != (active[i - 1] > 0);
    }
    total<2, 0>(v, work);
    give(v, out);
}

// Weights outside the active set, in place of those that its smoothed indicator gives.
KERNEL outside(FIELD, const REAL* active, REAL* weights, double noise, double* work, double* out) {
    double largest[1] = {0};
    CELLS(cells) largest[0] = weights[i] > largest[0] ? weights[i] : largest[0];
    total<0, 1>(largest, work);
    const REAL least = noise * largest[0];
    CELLS(cells) weights[i] = (1 - active[i]) / (weights[i] > least ? weights[i] : least);
}

KERNEL combine(FIELD, REAL* extended, const REAL* outside, const REAL* displacement, double* work, double* out) {
    CELLS(cells) extended[i] = extended[i] * outside[i] + displacement[i];
}

KERNEL multiply(FIELD, const REAL* first, const REAL* second, REAL* product, double* work, double* out) {
    CELLS(cells) product[i] = first[i] * second[i];
}

KERNEL gather(FIELD, REAL* pressure, const REAL* gathered, const REAL* active, double* work, double* out) {
    CELLS(cells) pressure[i] = (pressure[i] + gathered[i]) * active[i];
}

// The next four are maps to and from blocks of 2 x 2 cells, `n` of them in a row.
KERNEL block_means(FIELD, const REAL* field, REAL* means, double* work, double* out) {
    const unsigned n = columns / 2;
    CELLS(cells / 4) {
        const unsigned at = i;
        const REAL* upper = field + 4 * (Index)n * (at / n) + 2 * (at % n);
        means[i] = REAL(0.25) * (upper[0] + upper[1] + upper[2 * n] + upper[2 * n + 1]);
    }
}

KERNEL block_means_transposed(FIELD, REAL* pressure, const REAL* blocks, const REAL* block_active,
                              const REAL* active, double* work, double* out) {
    const unsigned n = columns / 2;
    CELLS(cells) {
        const unsigned at = i, b = at / (4 * n) * n + at % (2 * n) / 2;
        const REAL part = block_active[b] > 0 ? blocks[b] / (4 * block_active[b]) : REAL(0);
        pressure[i] = (pressure[i] + part) * active[i];
    }
}

KERNEL interpolated_outside(FIELD, const REAL* displacement, const REAL* blocks, const REAL* active,
                            REAL* extended, double* work, double* out) {
    const unsigned n = columns / 2, m = cells / (4 * n);
    CELLS(cells) {
        const unsigned at = i, row = at / (2 * n), column = at % (2 * n), k = row / 2, j = column / 2;
        const unsigned k2 = (k + (row % 2 ? 1 : m - 1)) % m, j2 = (j + (column % 2 ? 1 : n - 1)) % n;
        const REAL near = REAL(0.75) * blocks[k * n + j] + REAL(0.25) * blocks[k2 * n + j];
        const REAL far = REAL(0.75) * blocks[k * n + j2] + REAL(0.25) * blocks[k2 * n + j2];
        extended[i] = (REAL(0.75) * near + REAL(0.25) * far) * (1 - active[i]) + displacement[i];
    }
}

KERNEL interpolated_outside_transposed(FIELD, const REAL* pressure, const REAL* active, REAL* blocks,
                                       double* work, double* out) {
    const unsigned n = columns / 2, m = cells / (4 * n);
    CELLS(cells / 4) {
        const unsigned at = i, top = 2 * (at / n) + 2 * m, left = 2 * (at % n) + 2 * n;
        REAL sum = 0;
        for (int r = -1; r < 3; ++r)
            for (int c = -1; c < 3; ++c) {
                const unsigned from = (top + r) % (2 * m) * (2 * n) + (left + c) % (2 * n);
                const REAL weight = (r == 0 || r == 1 ? REAL(0.75) : REAL(0.25)) * (c == 0 || c == 1 ? REAL(0.75) : REAL(0.25));
                sum += weight * (1 - active[from]) * pressure[from];
            }
        blocks[i] = sum;
    }
}
