// Soil-node kernel in the instruction set of the build.
#define GROUSER_NODE_KERNEL run_base
#include "node_kernel.inc"
