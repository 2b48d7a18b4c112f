// Soil-node kernel for AVX-512.
#define GROUSER_NODE_KERNEL run_avx512
#include "node_kernel.inc"
