#define GROUSER_KERNEL kernel_base
#define GROUSER_KERNEL_NAME "base"
#include "kernel_body.h"
