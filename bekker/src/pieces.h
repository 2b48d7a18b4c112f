#pragma once
#include <array>

#include "kernel.h"

namespace grouser::bekker {

/// A piece and the powers of its map at the near (coordinate `start`) and the far end.
struct MappedPiece {
  Piece piece;
  int p, q;
  int size;     ///< index into kRuleSizes of the rule to begin with
  bool verify;  ///< compare with the next rule; else the size is enough for 1e-6, and the null sums alone are looked at
};

inline constexpr int kMostPieces = 48;
/// The arc cut at every kink, jump and near-singular point of its stresses and at the end of every thin layer of shear.
struct Pieces {
  std::array<MappedPiece, kMostPieces>
      at;  // filled up to count only: clearing it would cost as much as finding the cuts
  int count = 0;
};
/// layers: cut those off; without, for a fixed number of points on two pieces.
Pieces pieces_of(const Arc& arc, double tolerance, bool layers = true);

}  // namespace grouser::bekker
