// One constant-velocity run, and its record on disk.
#include <algorithm>
#include <cmath>

#include "compact_file.h"
#include "grouser/sdem/campaign.h"

namespace grouser::sdem {

namespace fs = std::filesystem;

namespace {

constexpr int kSamples = 25;      ///< a window
constexpr double kRest = 0.1;     ///< [s] for grains around a wheel that takes its place among them
constexpr double kBeyond = 0.01;  ///< of the domain, beyond floor and walls [m]
constexpr const char* kKind = "sdem run";

/// Sums over a window.
struct Window {
  struct Sum {
    double dx = 0, dz = 0, vx = 0, vz = 0;
    int n = 0;
  };
  std::vector<Sum> grains;
  std::vector<double> bin_fx, bin_fz;
  double height = 0, time = 0, begin_time = 0;
  Vec3 impulse = Vec3::Zero(), angular = Vec3::Zero();
  int samples = 0;
};

class ConstantVelocity {
 public:
  ConstantVelocity(const Campaign& c, const CampaignRun& r, const dem::Packing& brick)
      : c_(c), r_(r), length_(r.bricks * brick.lx), solver_(make(brick)) {
    solver_.add_floor(0, 1);
    if (!c.periodic) {
      const int walls = solver_.add_body({});
      solver_.add_plane(walls, Vec3::Zero(), Vec3::UnitY(), 1);
      solver_.add_plane(walls, Vec3(0, brick.ly, 0), -Vec3::UnitY(), 1);
    }
    dem::BodySettings b;
    b.X_WB.p = start();
    wheel_ = solver_.add_body(b);
    solver_.add_cylinder(wheel_, c.radius, 0.5 * c.width + c.soil.largest, 0);
  }

  RunRecord run(const RunProgress& progress) {
    const double dt = c_.soil.dt, speed = std::hypot(r_.vx, r_.vz);
    if (r_.vz > 0) solver_.step(static_cast<long>(kRest / dt));
    solver_.set_motion(wheel_, {{r_.vx, 0, r_.vz}, {0, r_.w, 0}});
    const long between = std::lround(c_.every / speed / dt), open = std::max(1L, std::lround(c_.over / speed / dt)),
               total = std::lround(r_.duration / dt), pieces = std::min<long>(kSamples, open);
    long done = 0;
    while (done + between <= total) {
      solver_.step(between - open);
      begin();
      for (long k = 0; k < pieces; ++k) {
        solver_.step((k + 1) * open / pieces - k * open / pieces);
        sample();
      }
      end();
      done += between;
      if (progress) progress(static_cast<double>(done) / static_cast<double>(total));
    }
    return std::move(record_);
  }

 private:
  Vec3 start() const { return {0.5 * c_.margin, 0.5 * c_.width, r_.vz < 0 ? r_.high : r_.low}; }

  dem::Solver make(const dem::Packing& brick) const {
    dem::SolverSettings s;
    s.materials = c_.soil.materials;
    s.law = c_.soil.law;
    s.dt = c_.soil.dt;
    s.precision = c_.soil.precision;
    const double beyond = c_.periodic ? 0 : kBeyond;
    s.domain.lo = Vec3(0, -beyond, -kBeyond);
    s.domain.hi = Vec3(length_, brick.ly + beyond, r_.high + 2 * c_.radius);
    s.domain.periodic = {true, c_.periodic, false};
    std::vector<dem::GrainState> grains = dem::tile(brick, r_.bricks, 1).grains;
    // A wheel that begins in the soil takes the place of what is there.
    const Vec3 hub = start();
    std::erase_if(grains, [&](const dem::GrainState& g) {
      const double dx = g.x[0] - hub[0], dz = g.x[2] - hub[2], reach = c_.radius + g.radius;
      return dx * dx + dz * dz < reach * reach;
    });
    for (dem::GrainState& g : grains) g.frozen = g.frozen || held(g);
    return dem::Solver(s, std::move(grains));
  }

  /// Without these the wheel would take the whole bed along: smooth floor and smooth sides bear no force along x.
  bool held(const dem::GrainState& g) const {
    const double layer = c_.soil.largest;
    return c_.rough_floor ? g.x[2] < layer : g.x[0] < layer || g.x[0] >= length_ - layer;
  }

  void begin() {
    w_ = Window();
    w_.bin_fx.assign(RunRecord::kBins, 0);
    w_.bin_fz.assign(RunRecord::kBins, 0);
    const dem::SurfaceReport b = solver_.body(wheel_);
    w_.impulse = b.impulse;
    w_.angular = b.angular_impulse;
    w_.begin_time = solver_.time();
  }

  void sample() {
    ++w_.samples;
    const Vec3 hub = solver_.pose(wheel_).p;
    w_.height += hub[2];
    w_.time += solver_.time();
    for (const dem::BodyContact& k : solver_.contacts(wheel_)) {
      const double angle = std::atan2(k.at[0], -k.at[2]);
      const auto bin = static_cast<std::size_t>(
          std::clamp(static_cast<int>((angle + pi) / (2 * pi) * RunRecord::kBins), 0, RunRecord::kBins - 1));
      w_.bin_fx[bin] += k.force[0];
      w_.bin_fz[bin] += k.force[2];
    }
    now_ = solver_.grains();
    w_.grains.resize(now_.size());
    for (std::size_t i = 0; i < now_.size(); ++i) {
      double dx = now_[i].x[0] - hub[0];
      dx -= length_ * std::round(dx / length_);
      const double dz = now_[i].x[2] - hub[2];
      if (std::abs(dx) > c_.reach + c_.soil.largest || std::abs(dz) > c_.reach + c_.soil.largest) continue;
      Window::Sum& s = w_.grains[i];
      s.dx += dx;
      s.dz += dz;
      s.vx += now_[i].v[0];
      s.vz += now_[i].v[2];
      ++s.n;
    }
  }

  void end() {
    const double n = w_.samples, span = solver_.time() - w_.begin_time;
    const dem::SurfaceReport b = solver_.body(wheel_);
    const Vec3 force = (b.impulse - w_.impulse) / span, torque = (b.angular_impulse - w_.angular) / span;
    const auto put = [](std::vector<float>& to, double x) { to.push_back(static_cast<float>(x)); };
    // Rounded, so that the file is small: positions to 10 um, velocities to 10 um/s.
    const auto rounded = [&](std::vector<float>& to, double x) { put(to, std::round(1e5 * x) / 1e5); };
    put(record_.time, w_.time / n);
    put(record_.height, w_.height / n);
    put(record_.fx, force[0]);
    put(record_.fz, force[2]);
    put(record_.torque, torque[1]);
    for (int k = 0; k < RunRecord::kBins; ++k) {
      put(record_.bin_fx, w_.bin_fx[static_cast<std::size_t>(k)] / n);
      put(record_.bin_fz, w_.bin_fz[static_cast<std::size_t>(k)] / n);
    }
    for (std::size_t i = 0; i < w_.grains.size(); ++i) {
      const Window::Sum& s = w_.grains[i];
      if (s.n != w_.samples) continue;
      rounded(record_.dx, s.dx / n);
      rounded(record_.dz, s.dz / n);
      rounded(record_.vx, s.vx / n);
      rounded(record_.vz, s.vz / n);
      put(record_.radius, now_[i].radius);
    }
    record_.first.push_back(static_cast<std::int64_t>(record_.dx.size()));
  }

  const Campaign& c_;
  const CampaignRun& r_;
  double length_;
  dem::Solver solver_;
  int wheel_ = 0;
  Window w_;
  std::vector<dem::GrainState> now_;
  RunRecord record_;
};

/// Every array of a record with its name, unit and meaning; rows: its first extent is the windows, `wide` the second.
template <class Record, class F>
void each_array(Record& r, F&& f) {
  f("window_time", "s", "middle of the window", r.time, 1);
  f("window_height", "m", "hub above the floor", r.height, 1);
  f("window_fx", "N", "soil on wheel, forward", r.fx, 1);
  f("window_fz", "N", "soil on wheel, upward", r.fz, 1);
  f("window_torque", "N m", "soil on wheel about the axle", r.torque, 1);
  f("bin_fx", "N", "soil on wheel by angle from the lowest point, -180 to 180 degrees, forward", r.bin_fx,
    RunRecord::kBins);
  f("bin_fz", "N", "the same, upward", r.bin_fz, RunRecord::kBins);
  f("dx", "m", "centre of a grain ahead of the hub, mean over the window", r.dx, 1);
  f("dz", "m", "the same over the hub", r.dz, 1);
  f("vx", "m/s", "velocity forward, mean over the window", r.vx, 1);
  f("vz", "m/s", "the same upward", r.vz, 1);
  f("radius", "m", "of the grain", r.radius, 1);
}

std::string content_hash(RunRecord r) {
  State s;
  each_array(r, [&](const char* name, const char*, const char*, const std::vector<float>& v, int) {
    std::vector<double> x(v.begin(), v.end());
    s.field(name, x);
  });
  s.field("first", r.first);
  return s.hash_text();
}

}  // namespace

dem::Packing campaign_brick(const Campaign& c, const fs::path& folder, const RunProgress& progress) {
  dem::PourSettings p;
  p.lx = c.brick;
  p.ly = c.width;
  p.height = c.bed_depth;
  p.slab = !c.periodic;
  return dem::cached_packing(c.soil, p, folder, [&](double done, double) {
    if (progress) progress(done);
  });
}

RunRecord simulate(const Campaign& c, const CampaignRun& r, const dem::Packing& brick, const RunProgress& progress) {
  return ConstantVelocity(c, r, brick).run(progress);
}

void write_run(const RunRecord& record, const CampaignRun& r, const fs::path& file) {
  write_whole(file, [&](const fs::path& part) {
    {
      Recorder out = Recorder::create(part, {kKind, r.inputs, "constant-velocity run", "sdem", GROUSER_VERSION, 0});
      out.set_attribute("inputs_hash", r.name);
      out.set_attribute("hash", content_hash(record));
      const std::vector<double> first(record.first.begin(), record.first.end());
      out.write_static({"first", "1", "number of the first grain of each window", "", 1}, first, {first.size()});
      out.close();
    }
    std::vector<CompactArray> arrays;
    each_array(record, [&](const char* name, const char* unit, const char* what, const std::vector<float>& v, int) {
      arrays.push_back({{name, unit, what, "C", 1}, v, {v.size()}});
    });
    add_compact(part, arrays);
  });
}

RunRecord read_run(const CampaignRun& r, const fs::path& file) {
  const RunFile in(file);
  const auto fail = [&file](const std::string& what) { throw ResultsError(file.string() + ": " + what); };
  if (in.attributes().kind != kKind) fail("is a " + in.attributes().kind + ", not a run of a campaign");
  if (in.attributes().scenario != r.inputs) fail("is a run of other inputs than its name says; remove it");
  RunRecord out;
  each_array(out, [&](const char* name, const char*, const char*, std::vector<float>& v, int) {
    if (!in.has(name)) return;  // none in this run
    const std::vector<double> x = in.read(name);
    v.assign(x.begin(), x.end());
  });
  const std::vector<double> first = in.read("first");
  out.first.assign(first.begin(), first.end());
  if (content_hash(out) != in.attribute("hash"))
    fail("is damaged: its content does not match its stored hash; remove it, the run is made again");
  return out;
}

}  // namespace grouser::sdem
