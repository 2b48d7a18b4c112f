#pragma once
// Soil under the way of one wheel: columns of equal width. Volume is kept: what a column loses goes to another, or is counted as compacted.
//
//   sum over columns of (h + c) column = constant          c: compacted height                                      (R1)
#include <cstdint>
#include <functional>
#include <vector>

#include "grouser/terrain/state.h"

namespace grouser::sdem {

/// A disc over the columns.
struct Overlap {
  double area = 0;             ///< of the disc below the soil as it lay [m^2]
  double length = 0;           ///< -dA/dz [m]
  double slope = 0;            ///< -dA/ds [m]: integral of the rim's slope
  double rear = 0, front = 0;  ///< first and last place of it, from the hub [m]
};

class Rut {
 public:
  Rut(double column, double radius) : column_(column), radius_(radius) {}
  /// Columns of `height(s)` wherever there are none yet, from a to b.
  void lay(double a, double b, const std::function<double(double)>& height);
  /// A rut that reads a field which others change too (field_wheel.h): columns of a..b only, at `height` now. What reaches the rim
  /// of the disc at (s, z), or is within kTouch of it, stays as it is.
  void renew(double s, double z, double a, double b, const std::function<double(double)>& height);
  /// As the soil lay before this pass: NaN where no column is.
  double before(double s) const;
  /// Both of one column go toward those of soil that comes from the side, by share.
  void drift(std::size_t i, double before, double now, double share) {
    before_[i] += share * (before - before_[i]);
    h_[i] += share * (now - h_[i]);
  }
  double compacted(std::size_t i) const { return compacted_[i]; }
  /// Of the disc with hub at (s, z) with the soil as it lay before this pass.
  Overlap overlap(double s, double z) const;

  struct Shares {
    double compaction = 0;  ///< of what the rim displaces
    double ahead = 0.5;     ///< of the rest
    double drag = 0;        ///< [m^2] taken from behind the contact and put ahead; negative: the other way
    double forward = 1;     ///< 1 or -1: where ahead is
  };
  /// The rim at (s, z) displaces what lies above it.
  void displace(double s, double z, const Shares& shares);

  double height(double s) const;  ///< now [m]; NaN where no column is
  /// Sum of (h + c) column [m^2], and the number of columns.
  double volume() const;
  double compacted() const;
  std::size_t size() const { return h_.size(); }
  double first() const { return (static_cast<double>(base_) + 0.5) * column_; }
  double column() const { return column_; }
  double place(std::size_t i) const { return (static_cast<double>(base_) + static_cast<double>(i) + 0.5) * column_; }
  double h(std::size_t i) const { return h_[i]; }
  void traverse(State& s);

 private:
  std::ptrdiff_t index(double s) const;
  double between(const std::vector<double>& h, double s) const;
  void put(std::ptrdiff_t from, int step, double volume, double length);
  void repose(std::ptrdiff_t from, std::ptrdiff_t to);

  double column_, radius_;
  std::int64_t base_ = 0;
  std::vector<double> h_, before_, compacted_;
  std::vector<double> spare_h_, spare_before_;  // of renew
};

}  // namespace grouser::sdem
