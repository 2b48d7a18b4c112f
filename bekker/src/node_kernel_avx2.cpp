// Soil-node kernel for AVX2 and FMA.
#define GROUSER_NODE_KERNEL run_avx2
#include "node_kernel.inc"
