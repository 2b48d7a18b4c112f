#include "kernel.h"

#include <cstring>

namespace grouser::dem {

const Kernel* find_kernel(const char* name) noexcept {
  const bool any = !name || !*name;
#ifdef GROUSER_DEM_X86
  __builtin_cpu_init();
  const bool wide = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                    __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw");
  if (wide && (any || !std::strcmp(name, "avx512"))) return &kernel_avx512;
  const bool middle = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  if (middle && (any || !std::strcmp(name, "avx2"))) return &kernel_avx2;
#endif
  return any || !std::strcmp(name, "base") ? &kernel_base : nullptr;
}

}  // namespace grouser::dem
