#pragma once
// Linear and quadratic closed forms of the wheel force (eqs 2.17 to 2.20), written as product integration: the
// integrals of eq 2.11 of a parabola or a straight line through stresses at a few angles are weighted sums of these
// stresses.
#include <array>

#include "arc.h"
#include "grouser/bekker/forces.h"

namespace grouser::bekker {

/// Angles and weights of one arc: integral of p(theta) {1, sin theta, cos theta} over the arc = sum of p_i {one_i,
/// sine_i, cosine_i} for every stress p (eqs 2.18 and 2.19 collected by stress). Pieces: rear and front branch (eq
/// 2.17); with lugs the front branch is cut where the concave tread enters; a reloading wheel also where it touches
/// and where virgin soil begins (eq 2.12); under braking where sliding turns round. Exact in the stresses to rounding
/// at any length of arc: no division by its length occurs.
class ProductRule {
 public:
  static constexpr int kMost = 48;
  ProductRule(const Arc& arc, Method method);  ///< the angles
  void weigh();                                ///< the weights

  int size() const { return n_; }
  const double* angles() const { return theta_.data(); }
  double one(int i) const { return one_[i]; }
  double sine(int i) const { return sine_[i]; }
  double cosine(int i) const { return cosine_[i]; }

 private:
  struct Piece {
    double from, to;
    int a, middle, b;  ///< nodes
    bool shared;       ///< a is the last piece's b
    bool rear;         ///< the whole rear branch
  };
  int node(double theta);

  bool parabola_;
  int n_ = 0, pieces_ = 0;
  std::array<double, kMost> theta_, one_, sine_, cosine_;
  std::array<Piece, 16> piece_;
};

/// Six components by `method` (quadratic or linear) of a case whose status_of is ok.
WheelWrench closed_form(const ForceCase& c, Method method);
/// The same; pressure_z: the part of Fz that the pressure alone carries [N].
WheelWrench closed_form(const Arc& arc, Method method, double& pressure_z);
/// The same on virgin soil with pressure parts, shear capacity and derivatives by the shear state, in the form of the
/// quadrature; `range` is left to the caller.
WheelForces closed_form_forces(const Arc& arc, Method method);

}  // namespace grouser::bekker
