#pragma once
// The inner loop, compiled once per instruction set and chosen at run time.
#include "facet.h"
#include "store.h"

namespace grouser::dem {

/// Everything that does not change during a step.
template <class R>
struct StepWork {
  Grain<R>* grains;
  Load<R>* loads;
  const LawTable<R>* law;
  R unit[3];  ///< metres per unit of position
  R dt;
  R implicit;  ///< dt, or 0 for explicit tangential and rolling damping
  R gravity[3];
  R drag;     ///< [1/s] velocity and spin decay, 0: none
  bool many;  ///< grains of more than the first material
  bool rate;  ///< mu_r,eff = min(mur |v_t|^2, 1)
  bool rate_without_spin;
  bool spring_cap;  ///< only the springs are capped (LIGGGHTS), not the sum of spring and damping
  bool ch3;
  bool cohesive;
};

/// Energies of contacts [J]: what the springs hold at the end of a step, and what left them or the grains on the way
/// from the positions of the last step to these, with the mean of the forces at both (README, "Energy").
struct Energies {
  double normal_spring = 0, tangential_spring = 0, rolling_spring = 0;
  double normal_damping = 0, tangential_damping = 0, rolling_damping = 0;
  double sliding = 0, rolling_slip = 0;
  double tangential_change = 0, rolling_change = 0;  ///< springs whose stiffness or direction changed under load
  double cohesion = 0;
};

/// Sums over the contacts of grains with a surface: force on it, torque about the origin of its body.
struct WallSum {
  double force[3] = {0, 0, 0}, torque[3] = {0, 0, 0};
  int contacts = 0;
};

/// A surface on its body, and where grains are: x in the frame of the body is turn^T ((p - origin) unit - from).
template <class R>
struct SurfaceWork {
  const Grain<R>* grains;
  ShapeKind kind;
  Int<R> origin[3];
  double unit[3], from[3];
  double turn[3][3];          ///< rotation of the body
  double radius, half_width;  ///< of a cylinder
};

struct StepLimits {
  double speed2 = 0;     ///< bound of |v|^2 [m2/s2]
  double stiffness = 0;  ///< largest sum of k_n/m over the contacts of a grain [1/s2]
};

template <class R>
struct KernelOf {
  /// `e`: null, or where the energies are added; then `past` belongs to the blocks.
  void (*pairs)(const StepWork<R>&, Block<R>* first, Block<R>* last, Past<R>* past, Energies* e);
  void (*walls)(const StepWork<R>&, const Motion<R>&, WallBlock<R>* first, WallBlock<R>* last, WallSum& sum,
                Energies* e);
  /// Geometry of contacts with triangles, spheres (a block of facets for every block) or a cylinder (none).
  void (*touch)(const SurfaceWork<R>&, WallBlock<R>* first, WallBlock<R>* last, FacetBlock* facets);
  void (*integrate)(const StepWork<R>&, std::size_t first, std::size_t last, StepLimits& limits);
};

struct Kernel {
  const char* name;
  KernelOf<float> single;
  KernelOf<double> full;
};
extern const Kernel kernel_base;
#ifdef GROUSER_DEM_X86
extern const Kernel kernel_avx2, kernel_avx512;
#endif
/// The best this machine runs, or the one named ("base", "avx2", "avx512"); nullptr when it cannot be run here.
const Kernel* find_kernel(const char* name) noexcept;

template <class R>
const KernelOf<R>& of(const Kernel& k);
template <>
inline const KernelOf<float>& of<float>(const Kernel& k) {
  return k.single;
}
template <>
inline const KernelOf<double>& of<double>(const Kernel& k) {
  return k.full;
}

}  // namespace grouser::dem
