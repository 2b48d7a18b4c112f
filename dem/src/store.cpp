#include "store.h"

#include <new>
#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace grouser::dem {

void* allocate_pages(std::size_t bytes) {
  const std::size_t huge = std::size_t{1} << 21, align = bytes >= 2 * huge ? huge : 128;
  const std::size_t whole = (bytes + align - 1) / align * align;
  void* p = std::aligned_alloc(align, whole);
  if (!p) throw std::bad_alloc();
#if defined(__linux__)
  if (align == huge) madvise(p, whole, MADV_HUGEPAGE);  // a wish: refused without harm
#endif
  return p;
}

}  // namespace grouser::dem
