#pragma once
// Soil as grains: its parameters, and packings poured from it.
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "grouser/dem/solver.h"

namespace grouser::dem {

/// Soil as grains. Defaults: Table 4.2 with the rate-dependent rolling coefficient; walls smooth with e = 0.06.
struct SoilSettings {
  SoilSettings();
  MaterialTable materials;              ///< 0: grains, 1: smooth walls
  std::optional<PairProperties> wheel;  ///< of grains and wheels of dem.sphere; else as two grains
  LawSettings law;
  double smallest = 0.0025, largest = 0.010;  ///< diameters [m], uniform by number
  double density = 3100;                      ///< of grains while pouring [kg/m3]
  double bulk_density = 1600;                 ///< aimed at by scaling the density of the grains [kg/m3]; 0: as poured
  double dt = 8e-6;
  double dt_share = 0;  ///< of the Rayleigh time of the smallest grain, that set_step() makes dt from; 0: dt stays
  Precision precision = Precision::single;
  unsigned seed = 1;  ///< packing
};
/// 8e-6 s with Table 4.2.
inline constexpr double kStepShare = 0.17;
/// dt = dt_share T_R of the smallest grain at its density while pouring, where dt_share > 0. Called after the last change.
void set_step(SoilSettings& soil);
/// Every input of a soil as text, one "name value" per line with all digits: what results and beds are known by.
std::string inputs_text(const SoilSettings& soil);
/// 16 hexadecimal digits of a text (64-bit FNV-1a).
std::string hash_text(const std::string& text);

/// Part of the work done, 0 to 1, and the time simulated [s]; long tests call it about a hundred times.
using Progress = std::function<void(double done, double time)>;

struct PourSettings {
  double lx = 0.05, ly = 0.05, height = 0.16;  ///< [m]
  /// false: periodic column, cut at `height`. true: box with smooth walls (material 1) that gets the mass of its volume
  /// at the bulk density; its surface ends where it ends.
  bool walls = false;
  /// With `walls` false: smooth walls square to y, periodic along x. Cut at `height`, as a column.
  bool slab = false;
  double compaction = 0;  ///< [Pa] pressed by a smooth lid and let go again
};
std::string inputs_text(const PourSettings& p);

struct Packing {
  std::vector<GrainState> grains;  ///< at rest; x, y from 0
  double lx = 0, ly = 0;           ///< base [m]
  bool walls = false;              ///< false: periodic
  bool slab = false;               ///< periodic along x only
  double height = 0;          ///< of the surface: mean of the highest grain tops over squares as wide as a grain [m]
  double bulk_density = 0;    ///< mass over base area and height [kg/m3]
  double settle_time = 0;     ///< simulated [s]
  double residual_speed = 0;  ///< mass-weighted rms velocity when the pouring ended [m/s]
  std::string inputs;         ///< how it was made
};
/// Grains rained into a column or box, settled under gravity, compacted where asked, density scaled to the aim. Seeded.
/// @throws DemError: sizes not positive, base narrower than two large grains.
Packing pour(const SoilSettings& soil, const PourSettings& p, const Progress& progress = {});
/// The same in pieces that can be saved in between and continued with the same bits.
class Pouring {
 public:
  /// @throws DemError as pour.
  Pouring(const SoilSettings& soil, const PourSettings& p);
  ~Pouring();
  bool advance();       ///< 20 ms further; false: at rest, the packing is ready
  double done() const;  ///< part of the time that this stage may take
  double time() const;  ///< simulated in this stage [s]
  Packing packing() const;
  /// Save, load. Loading wants the same inputs and nothing done yet.
  void traverse(State& s);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};
/// The same with its state saved in `checkpoint` every `every` seconds of the clock, and continued from there when that is a state of
/// the same inputs and version (another one is ignored). The file stays: whoever stores the packing removes it afterwards.
/// @throws DemError; ResultsError when the file is damaged or cannot be written.
Packing pour(const SoilSettings& soil, const PourSettings& p, const std::filesystem::path& checkpoint, double every,
             const Progress& progress = {});
/// The same for a periodic column lx x ly.
Packing pour_periodic(const SoilSettings& soil, double lx, double ly, double height, const Progress& progress = {});
/// Copies of a periodic packing side by side.
std::vector<GrainState> tile(const std::vector<GrainState>& grains, double lx, double ly, int nx, int ny);

/// The same with the packing's numbers. @throws DemError: not periodic.
Packing tile(const Packing& brick, int nx, int ny);
/// Takes away grains whose centre lies above `height(x, y)` [m]; the surface height becomes the mean of the new one.
void cut_surface(Packing& p, const std::function<double(double x, double y)>& height);
/// Freezes grains whose centre lies within `border` of the sides or `bottom` of z = 0 [m].
void freeze_edges(Packing& p, double border, double bottom);
/// Lets a packing come to rest under gravity in its own box (periodic or walled), `limit` [s] at most.
void relax(Packing& p, const SoilSettings& soil, double limit, const Progress& progress = {});

/// Porosity of horizontal layers [1], bottom first: 1 - solid volume/volume, spheres cut exactly by the layers.
std::vector<double> porosity_profile(const Packing& p, int layers);

/// HDF5 file of a packing with all inputs and a hash. Written whole or not at all.
/// @throws ResultsError.
void write_bed(const Packing& p, const std::filesystem::path& file, const std::string& title);
/// @throws ResultsError: not a bed, or its content does not match its hash.
Packing read_bed(const std::filesystem::path& file);
/// The packing of these inputs from `folder`, poured and stored there when it is not yet. Safe from several threads and
/// processes: of two that want the same packing at once, one saves what it has (file of the packing with `.checkpoint`, locked), and a
/// killed one is continued. An empty folder: poured every time. `every`: seconds of the clock between checkpoints.
Packing cached_packing(const SoilSettings& soil, const PourSettings& p, const std::filesystem::path& folder,
                       const Progress& progress = {}, double every = 30);

}  // namespace grouser::dem
