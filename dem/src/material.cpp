#include "grouser/dem/material.h"

#include <utility>

namespace grouser::dem {

std::size_t MaterialTable::index(int a, int b) const {
  if (a > b) std::swap(a, b);
  const int n = static_cast<int>(materials.size());
  return static_cast<std::size_t>(a * n - a * (a - 1) / 2 + (b - a));
}

int MaterialTable::add(Material m, const PairProperties& p) {
  const MaterialTable old = *this;
  materials.push_back(std::move(m));
  const int n = static_cast<int>(materials.size());
  pairs.assign(static_cast<std::size_t>(n * (n + 1) / 2), p);
  for (int a = 0; a < n - 1; ++a)
    for (int b = a; b < n - 1; ++b) pair(a, b) = old.pair(a, b);
  return n - 1;
}

}  // namespace grouser::dem
