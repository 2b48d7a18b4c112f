#define GROUSER_KERNEL kernel_avx512
#define GROUSER_KERNEL_NAME "avx512"
#include "kernel_body.h"
