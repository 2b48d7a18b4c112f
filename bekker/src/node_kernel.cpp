#include "node_kernel.h"

namespace grouser::bekker::node {

void run_base(const Gear&, const Material*, int, const Segment*, int, Sums&);
#ifdef GROUSER_BEKKER_X86
void run_avx2(const Gear&, const Material*, int, const Segment*, int, Sums&);
void run_avx512(const Gear&, const Material*, int, const Segment*, int, Sums&);
#endif

Kernel kernel() {
#ifdef GROUSER_BEKKER_X86
  static const Kernel best = [] {
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) return &run_avx512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return &run_avx2;
    return &run_base;
  }();
  return best;
#else
  return run_base;
#endif
}

}  // namespace grouser::bekker::node
