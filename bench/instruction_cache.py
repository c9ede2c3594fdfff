#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes a CUDA program that measures how fast a GPU fetches instructions (docs/gpu.md).

usage: instruction_cache.py > cache.cu && nvcc -arch=sm_90 -O1 -o cache cache.cu && ./cache

Each warp takes pieces of 128 multiply-adds, 2 kB, in random order: its own, or with a barrier
before each piece the same as all others of its block. Prints the cycles of a warp for an
instruction, over the number of warps and of different pieces. Standard library only.
"""
PIECES = 256
MULTIPLY_ADDS = 128  # in four chains, so that a warp waits little for its own results

HEAD = """#include <cstdio>

__global__ void run(int pieces, int rounds, double* results, long long* cycles, bool in_step) {
  double x0 = threadIdx.x, x1 = x0 + 1, x2 = x0 + 2, x3 = x0 + 3;
  const double b = 1.0 + 1e-9, c = 1e-3;
  unsigned random = in_step ? 12345u : (threadIdx.x / 32 + 1) * 2654435761u + blockIdx.x * 97;
  __syncthreads();
  const long long begin = clock64();
  for (int round = 0; round < rounds; ++round) {
    random = random * 1664525u + 1013904223u;
    switch ((random >> 16) % pieces) {"""

TAIL = """    }
    if (in_step) __syncthreads();
  }
  const long long end = clock64();
  const int thread = blockIdx.x * blockDim.x + threadIdx.x;
  results[thread] = x0 + x1 + x2 + x3;
  if (threadIdx.x % 32 == 0) cycles[thread / 32] = end - begin;
}

int main() {
  constexpr int blocks = 132, most_warps = 32, rounds = 2000;
  double* results;
  long long *cycles, found[blocks * most_warps];
  cudaMalloc(&results, sizeof(double) * blocks * most_warps * 32);
  cudaMalloc(&cycles, sizeof(found));
  for (const bool in_step : {false, true})
    for (const int warps : {4, 8, 16, 32})
      for (const int pieces : {1, 8, 16, 24, 32, 48, 64, 96, 128, 256}) {
        for (const int times : {rounds / 10, rounds})  // the first brings the code near
          run<<<blocks, warps * 32>>>(pieces, times, results, cycles, in_step);
        const cudaError_t fault =
            cudaMemcpy(found, cycles, sizeof(long long) * blocks * warps, cudaMemcpyDeviceToHost);
        if (fault != cudaSuccess) {
          std::fprintf(stderr, "%s\\n", cudaGetErrorString(fault));
          return 1;
        }
        double sum = 0;
        for (int i = 0; i < blocks * warps; ++i) sum += found[i];
        std::printf("%-8s %2d warps, %3d kB: %6.2f cycles an instruction\\n",
                    in_step ? "in step" : "apart", warps, 2 * pieces,
                    sum / (blocks * warps) / rounds / INSTRUCTIONS);
      }
}"""


def main():
    turn = "".join(f"fma.rn.f64 %{i},%{i},%4,%5;" for i in range(4))
    print(HEAD)
    for piece in range(PIECES):
        # each differs from the others, so that no compiler takes two of them for one
        print(f'      case {piece}: asm volatile("add.f64 %0,%0,'
              f'0d{0x3FF0000000000000 + piece * 4096:016X};{turn * (MULTIPLY_ADDS // 4)}"'
              ' : "+d"(x0), "+d"(x1), "+d"(x2), "+d"(x3) : "d"(b), "d"(c)); break;')
    # with the sum and some three to choose the piece
    print(TAIL.replace("INSTRUCTIONS", str(MULTIPLY_ADDS + 4)))


if __name__ == "__main__":
    main()
