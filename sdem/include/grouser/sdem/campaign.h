#pragma once
// Campaign of constant-velocity runs (dissertation 5.2.1, Table 5.1) from which tables are made: plan, one run, post-processing.
//
// One run: a wheel of velocity (w, vx, vz) through a slab of grains, between smooth walls or (`periodic`) its own neighbour across. For vz < 0 it starts clear of the soil and ends
// `floor_distance` above the floor; for vz > 0 the other way. Height of the hub above the floor, between
//   low = floor_distance + r  and  high = bed_depth + clearance + r,   T = (high - low)/|vz|                         (C1)
// over a bed `margin` + |vx| T long, periodic along x. A layer of grains as thick as the largest one stands still: on the floor (`rough_floor`)
// or at both ends, half of `margin` from the hub at the start and at the end of its way. States are averaged over `over` of the hub's way, every `every` of it.
// Every run is one file in a folder, named by the hash of its inputs: a finished run is never computed again, a killed one begins anew.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "grouser/dem/packing.h"
#include "grouser/sdem/tables.h"

namespace grouser::sdem {

struct Campaign {
  std::string title, source;
  std::string wheel;             ///< name
  double radius = 0, width = 0;  ///< r, of wheel and slab [m]
  bool periodic = false;         ///< no side walls: the slab is its own neighbour across
  bool rough_floor =
      false;  ///< the lowest grains stand still; else the floor is smooth and grains at both ends stand still
  dem::SoilSettings soil;
  std::vector<double> w, vx, vz;                                      ///< nodes [rad/s], [m/s]; vz without 0
  double bed_depth = 0.155, floor_distance = 0.03, clearance = 0.02;  ///< [m]
  double margin = 0.88;                                               ///< bed at vx = 0 [m]
  double brick = 0.1;                                                 ///< poured once, then repeated along the bed [m]
  double over = 0.25e-3, every = 2.5e-3;                              ///< [m]
  double cell = 0.004, reach = 0.195;                                 ///< of the tables [m]
};

struct CampaignRun {
  double w = 0, vx = 0, vz = 0;
  double low = 0, high = 0;  ///< hub above the floor [m]
  double duration = 0;       ///< [s]
  int bricks = 0;            ///< along the bed
  std::string inputs;        ///< everything it depends on
  std::string name;          ///< of its file: hash of the inputs
};

/// @throws ConfigError with every error. Keys: examples/14_surrogate/README.md.
Campaign load_campaign(const std::filesystem::path& file);
/// Every combination of the nodes, in the order of Tables::node.
std::vector<CampaignRun> plan_of(const Campaign& c);
/// Grain steps of a run [1]: grains (from densities) times steps. At some 40 million a second one core.
double grain_steps(const Campaign& c, const CampaignRun& r);

/// What a run leaves: one entry a window; grains of window k: first[k] .. first[k + 1].
struct RunRecord {
  static constexpr int kBins = 180;           ///< round the wheel
  std::vector<float> time, height;            ///< middle of the window [s], hub above the floor [m]
  std::vector<float> fx, fz, torque;          ///< mean over the window [N], [N m], soil on wheel, about y
  std::vector<float> bin_fx, bin_fz;          ///< by angle from the lowest point, -pi .. pi, window x kBins [N]
  std::vector<float> dx, dz, vx, vz, radius;  ///< grains within reach: centre from the hub [m], [m/s], [m]
  std::vector<std::int64_t> first{0};
  std::size_t windows() const { return time.size(); }
};

/// done: 0 to 1.
using RunProgress = std::function<void(double done)>;
/// Simulates. @throws dem::DemError.
RunRecord simulate(const Campaign& c, const CampaignRun& r, const dem::Packing& brick,
                   const RunProgress& progress = {});
/// Brick of the bed, poured or from `folder`.
dem::Packing campaign_brick(const Campaign& c, const std::filesystem::path& folder, const RunProgress& progress = {});

/// Written whole or not at all. @throws ResultsError.
void write_run(const RunRecord& record, const CampaignRun& r, const std::filesystem::path& file);
/// @throws ResultsError: missing, damaged, of other inputs.
RunRecord read_run(const CampaignRun& r, const std::filesystem::path& file);

/// Tables from all runs, records in the order of plan_of (asked for one by one, so that one is in memory at a time).
///   soil: for each window and column of cells, the uppermost cell with a grain is the profile; its mean velocity is an entry at (dx, profile)
///   wheel: forces by angle, spread over the mean grain's diameter, over the rim it touches; entry at the nearest height (bottom) or profile (top)
///   entries of a cell are averaged; cells without any are estimated (each the mean of its neighbours); all are smoothed once by (1 2 1)/4
///   along both axes within their region.
Tables make_tables(const Campaign& c, const std::vector<CampaignRun>& runs,
                   const std::function<RunRecord(std::size_t run)>& record);

}  // namespace grouser::sdem
