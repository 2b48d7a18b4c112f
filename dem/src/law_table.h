#pragma once
#include "grouser/dem/material.h"
#include "store.h"

namespace grouser::dem {

/// Coefficients of every pair of materials in the order of MaterialTable::pairs.
template <class R>
LawTable<R> law_table(const MaterialTable& m, const LawSettings& s);

}  // namespace grouser::dem
