#define GROUSER_KERNEL kernel_avx2
#define GROUSER_KERNEL_NAME "avx2"
#include "kernel_body.h"
