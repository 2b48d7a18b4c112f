#include "grouser/vehicle/simulation.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "extent_watch.h"
#include "ground_view.h"
#include "grouser/terrain/checkpoint.h"
#include "grouser/terrain/ground_frame.h"
#include "grouser/vehicle/folder_lock.h"
#include "grouser/vehicle/scenario.h"
#include "model_error.h"
#include "run_record.h"

namespace grouser::vehicle {

namespace fs = std::filesystem;

namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

std::string seconds(double t) {
  char buf[32];
  std::snprintf(buf, sizeof buf, "%.6f s", t);
  return buf;
}

class Run {
 public:
  Run(Scenario s, std::string text, fs::path folder, int threads, std::function<void(const Progress&)> progress)
      : scenario_(std::move(s)),
        text_(std::move(text)),
        folder_(std::move(folder)),
        threads_(threads),
        progress_(std::move(progress)) {}

  /// Left by an exception (of the progress callback, say): the newest checkpoint is not lost.
  ~Run() {
    try {
      if (pending_ && record_) write(*pending_);
    } catch (const std::exception&) {  // the older file stays
    }
  }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  RunSummary fresh() {
    build();
    record_.emplace(RunRecord::create(folder_ / "run.h5", scenario_, text_, *driver_));
    if (const TrimResult r = world_->trim(scenario_.start); !r.ok) record_->recorder().set_attribute("trim", r.why);
    settle();
    checkpoint();
    terrain_s_ = 0;  // settling is not part of the run's time
    return loop();
  }

  RunSummary resume(const Checkpoint& c) {
    build();
    record_.emplace(RunRecord::resume(folder_ / "run.h5", scenario_, c.frames));
    State state = c.state;
    load(state);
    last_checkpoint_ = c.time;
    return loop();
  }

 private:
  void build() {
    std::shared_ptr<Terrain> terrain = scenario_.make_terrain();
    terrain->set_threads(threads_);
    WorldOptions o;
    o.gravity = scenario_.gravity;
    // The clock of the terrain that goes away is kept.
    if (world_) terrain_s_ += world_->terrain_seconds();
    world_.reset();
    world_ = std::make_unique<VehicleWorld>(scenario_.vehicle, std::move(terrain), o);
    driver_ = scenario_.make_driver();
    command_.wheels.assign(scenario_.vehicle.wheels.size(), {});
    command_.steer.assign(scenario_.vehicle.steering.size(), 0.0);
  }

  void traverse(State& s) {
    totals_.traverse(s);
    extent_.traverse(s);
    s.field("speed_at_start", speed_at_start_);
    {
      auto g = s.group("driver");
      driver_->traverse(s);
    }
    auto g = s.group("vehicle");
    world_->traverse(s);
  }
  void load(State& state) {
    state.rewind(State::Mode::load);
    traverse(state);
    state.finish();
  }
  double time() const { return static_cast<double>(totals_.step) * scenario_.time_step; }

  double fastest_body() const {
    double v = 0;
    for (std::size_t i = 0; i < scenario_.vehicle.links.size(); ++i)
      v = std::max(v, world_->twist(static_cast<int>(i)).v.norm());
    return v;
  }

  /// Stand still for the time that the scenario says, or until at rest; then count from there.
  void settle() {
    const auto steps = [&](double t) { return std::lround(t / scenario_.time_step); };
    const long n = steps(scenario_.settle.value_or(settle_limit)), quiet_enough = steps(rest_time);
    long i = 0;
    for (long quiet = 0; i < n && (scenario_.settle || quiet < quiet_enough); ++i) {
      driver_->command(-1.0, scenario_.time_step, view_of(*world_), command_);
      guarded_step(static_cast<double>(i - n) * scenario_.time_step);
      quiet = fastest_body() < rest_speed ? quiet + 1 : 0;
    }
    Recorder& r = record_->recorder();
    r.set_attribute("settled_for_s", static_cast<double>(i) * scenario_.time_step);
    speed_at_start_ = fastest_body();
    r.set_attribute("speed_at_start_m_s", speed_at_start_);
    world_->reset_energy();
    totals_.soil_0 = world_->terrain().energy();
    frame(1.0);
  }

  void frame(double frame_dt) {
    record_->frame(time(), frame_dt, *world_, world_->terrain().energy(), totals_);
    record_->points(time(), world_->terrain());
    if (extent_.look(time(), *world_, *scenario_.ground)) write_warnings();
  }

  /// Written when one comes up and again at the end, so that a killed run has it too.
  std::vector<std::string> warnings() const {
    std::vector<std::string> all = extent_.warnings(scenario_.vehicle);
    if (const std::string w = outside_warning(world_->terrain()); !w.empty()) all.push_back(w);
    if (speed_at_start_ >= rest_speed) {
      char text[200];
      std::snprintf(text, sizeof text,
                    "the vehicle was not at rest when the run began: after %.3g s of standing still a body moved at "
                    "%.2g m/s; set start.settle "
                    "or another start",
                    scenario_.settle.value_or(settle_limit), speed_at_start_);
      all.emplace_back(text);
    }
    add_coarse_step(all);
    return all;
  }

  /// The step against the stiffest contact, and what the step itself did to the energy.
  void add_coarse_step(std::vector<std::string>& all) const {
    if (scenario_.vehicle.wheels.empty()) return;
    int stiffest = 0;
    for (int i = 1; i < static_cast<int>(scenario_.vehicle.wheels.size()); ++i)
      if (world_->contact_rate(i) > world_->contact_rate(stiffest)) stiffest = i;
    const double rate = world_->contact_rate(stiffest), dt = scenario_.time_step;
    const VehicleEnergy& e = world_->energy();
    const double weight = scenario_.vehicle.total_mass() * scenario_.gravity;
    const double by_step = std::abs(e.implicit) / std::max(e.yardstick(), 1e-3 * weight);  // at least 1 mm of height
    if (rate * dt <= well_resolved || (rate * dt <= coarse_step && by_step <= coarse_share)) return;
    char text[400];
    std::snprintf(
        text, sizeof text,
        "time_step %.3g ms does not resolve the contact of wheel '%s', which rings at %.0f Hz across the "
        "surface: the step itself %s %.2g J, %.2g %% of the %s (energy.implicit_correction), and the loads of "
        "bounces are smoothed; time_step %.2g ms resolves it",
        1e3 * dt, scenario_.vehicle.wheels[stiffest].name.c_str(), rate / (2 * pi),
        e.implicit < 0 ? "takes" : "gives back", std::abs(e.implicit), 100 * by_step, e.yardstick_name(),
        1e3 * fine_step / rate);
    all.emplace_back(text);
  }

  void write_warnings() {
    const auto warnings = this->warnings();
    if (!warnings.empty()) record_->recorder().set_attribute("warnings", nlohmann::json(warnings).dump());
  }

  void guarded_step(double t) {
    try {
      world_->step(scenario_.time_step, command_);
    } catch (const TerrainError& e) {
      stop(t, first_bad_body(), e.what());
    } catch (const GroundError& e) {
      stop(t, wheel_off_ground(), std::string("lost wheel: off the map: ") + e.what());
    } catch (const ConfigError&) {
      throw;
    } catch (const std::runtime_error& e) {
      stop(t, first_bad_body(), e.what());
    }
    check(t + scenario_.time_step);
  }

  std::string first_bad_body() const {
    const int i = world_->first_not_finite();
    return i >= 0 ? scenario_.vehicle.links[i].name : "vehicle";
  }

  std::string wheel_off_ground() const {
    const VehicleSpec& v = scenario_.vehicle;
    for (const double reach : {0.0, 0.5, 1.0, 1.5, 2.0})  // the wheel that is farthest out
      for (const WheelSpec& w : v.wheels) {
        const Pose X = world_->pose(w.link);
        const Vec3 axle_B = v.links[w.link].X_VB.q.conjugate() * v.joints[w.joint].axis_V;
        if (!off_ground(*scenario_.ground, w.gear, X.p, X.q * axle_B, reach).empty()) return w.name;
      }
    return "vehicle";
  }

  void check(double t) {
    if (const int i = world_->first_not_finite(); i >= 0)
      stop(t, scenario_.vehicle.links[i].name, "position or velocity is not a number");
    const VehicleSpec& v = scenario_.vehicle;
    for (std::size_t i = 0; i < v.links.size(); ++i)
      if (const double speed = world_->twist(static_cast<int>(i)).v.norm(); speed > fastest)
        stop(t, v.links[i].name, "runaway energy: speed is " + std::to_string(speed) + " m/s (limit 100 m/s)");
    // Wheels do not get lost from one step to the next: a hundredth of a second is soon enough.
    const bool look_for_wheels = totals_.step % std::max(1L, std::lround(0.01 / scenario_.time_step)) == 0;
    for (const WheelSpec& w : v.wheels) {
      if (!look_for_wheels) break;
      const Vec3 p = world_->pose(w.link).p;
      double ground = 0;
      try {
        ground = scenario_.ground->height(p.x(), p.y());
      } catch (const std::exception& e) {
        stop(t, w.name, std::string("lost wheel: off the map: ") + e.what());
      }
      const double r = w.gear.outer_radius(), height = p.z() - ground;
      char text[160];
      if (height < -2 * r) {
        std::snprintf(text, sizeof text,
                      "lost wheel: its centre is %.3f m below the undisturbed ground (radius %.3f m)", -height, r);
        stop(t, w.name, text);
      }
      if (height > r + lost_height) {
        std::snprintf(text, sizeof text, "lost wheel: its centre is %.3f m above the ground", height);
        stop(t, w.name, text);
      }
    }
    // More mechanical energy than the motors and a tenth of a metre of height can have given.
    const VehicleEnergy& e = world_->energy();
    if (t > 0) {
      const double gain = e.kinetic - e.kinetic_0 + e.potential + e.spring - e.spring_0;
      if (gain > 2 * e.motor_gross + v.total_mass() * (0.1 * scenario_.gravity + 0.5))
        stop(t, "vehicle",
             "runaway energy: the vehicle has " + std::to_string(gain) + " J more than at the start, the motors gave " +
                 std::to_string(e.motor) + " J");
    }
  }

  [[noreturn]] void stop(double t, const std::string& body, const std::string& why) {
    if (pending_) write(*pending_);
    pending_.reset();
    const std::string message =
        "stopped at t = " + seconds(t) + ", body '" + body + "': " + why +
        "; last good checkpoint: " + (last_checkpoint_ >= 0 ? "t = " + seconds(last_checkpoint_) : std::string("none"));
    if (record_) {
      write_warnings();
      record_->recorder().set_attribute("status", "stopped: " + message);
      record_->recorder().set_attribute("simulated_s", time());
      record_->recorder().close();
      record_.reset();
      write_xdmf(folder_ / "run.h5", folder_ / "run.xdmf");
    }
    throw SimulationError(message);
  }

  /// Save, then build everything anew from what was saved, as a resumed run does. A run that is much faster than real time keeps it in
  /// memory unless the file is older than file_age: bits do not depend on which of its checkpoints a run goes on from.
  void checkpoint() {
    const auto begin = Clock::now();
    Checkpoint& c = pending_.emplace();
    c.scenario = text_;
    c.version = GROUSER_VERSION;
    c.time = time();
    c.frames = record_->recorder().frames();
    traverse(c.state);
    const bool due = last_checkpoint_ < 0 || since(written_) > file_age;
    if (due) write(c);
    State state = due ? std::move(c.state) : c.state;
    if (due) pending_.reset();
    build();
    load(state);
    output_s_ += since(begin);
  }

  void write(const Checkpoint& c) {
    record_->recorder().flush();
    write_checkpoint(folder_ / "checkpoint.h5", c);
    last_checkpoint_ = c.time;
    written_ = Clock::now();
  }

  RunSummary loop() {
    const auto begin = Clock::now();
    auto last_progress = begin;
    const long end = scenario_.steps(), per_frame = scenario_.steps_per_frame(),
               per_checkpoint = scenario_.steps_per_checkpoint();
    const std::int64_t first_step = totals_.step;
    const double dt = scenario_.time_step;
    double step_s = 0;
    while (totals_.step < end) {
      const auto step_begin = Clock::now();
      const VehicleView view = view_of(*world_);
      driver_->command(time(), dt, view, command_);
      guarded_step(time());
      ++totals_.step;
      const Vec3 velocity = world_->twist(0).v;
      totals_.distance += dt * std::hypot(velocity.x(), velocity.y());
      step_s += since(step_begin);
      if (totals_.step % per_frame == 0) {
        const auto frame_begin = Clock::now();
        totals_.drift = std::max(totals_.drift, world_->joint_drift());
        frame(static_cast<double>(per_frame) * dt);
        output_s_ += since(frame_begin);
        if (progress_ && since(last_progress) > 0.1) {
          last_progress = Clock::now();
          progress_({time(), scenario_.duration, since(begin)});
        }
      }
      if (totals_.step % per_checkpoint == 0 && totals_.step < end) checkpoint();
    }
    totals_.drift = std::max(totals_.drift, world_->joint_drift());

    RunSummary r;
    r.folder = folder_;
    r.simulated_s = static_cast<double>(totals_.step - first_step) * dt;
    r.terrain_s = terrain_s_ + world_->terrain_seconds();
    r.bullet_s = std::max(0.0, step_s - r.terrain_s);
    State state;
    traverse(state);
    r.end_state_hash = state.hash_text();
    const VehicleEnergy& e = world_->energy();
    r.energy_residual_ratio = std::abs(total_residual(e, world_->terrain().energy(), totals_.soil_0)) / e.yardstick();
    r.joint_drift_m = totals_.drift;
    r.total_mass = scenario_.vehicle.total_mass();
    // The last state is a checkpoint too: a longer run may go on from it.
    Checkpoint c;
    c.scenario = text_;
    c.version = GROUSER_VERSION;
    c.time = time();
    c.frames = record_->recorder().frames();
    c.state = state;
    write(c);
    pending_.reset();
    r.warnings = warnings();
    r.notices = scenario_.notices;
    write_warnings();
    Recorder& rec = record_->recorder();
    rec.set_attribute("end_state_hash", r.end_state_hash);
    rec.set_attribute("status", "finished");
    rec.set_attribute("simulated_s", time());
    r.energy_yardstick_J = e.yardstick();
    r.energy_step_J =
        e.implicit + e.integration - (world_->terrain().energy().integration - totals_.soil_0.integration);
    r.energy_yardstick = e.yardstick_name();
    rec.set_attribute("energy_residual_ratio", r.energy_residual_ratio);
    rec.set_attribute("energy_yardstick_J", r.energy_yardstick_J);
    rec.set_attribute("energy_yardstick", r.energy_yardstick);
    rec.set_attribute("joint_drift_max", r.joint_drift_m);
    const auto closing = Clock::now();
    rec.flush();
    r.output_s = output_s_ + since(closing);
    r.wall_s = since(begin);
    rec.set_attribute("timing.bullet_s", r.bullet_s);
    rec.set_attribute("timing.terrain_s", r.terrain_s);
    rec.set_attribute("timing.output_s", r.output_s);
    rec.set_attribute("timing.wall_s", r.wall_s);
    rec.set_attribute("timing.simulated_s", r.simulated_s);
    rec.close();
    record_.reset();
    write_xdmf(folder_ / "run.h5", folder_ / "run.xdmf");
    if (progress_) progress_({time(), scenario_.duration, since(begin)});
    return r;
  }

  // dt omega of a contact: warned above, warned above where the step has more than coarse_share of the energy, advised
  static constexpr double coarse_step = 0.5, well_resolved = 0.2, fine_step = 0.125, coarse_share = 0.05;
  static constexpr double fastest = 100;                                          // [m/s]
  static constexpr double lost_height = 5;                                        // [m]
  static constexpr double rest_speed = 1e-4, rest_time = 0.5, settle_limit = 30;  // [m/s], [s], [s]
  static constexpr double file_age = 0.5;                                         // [s] of the clock

  Scenario scenario_;
  std::string text_;
  fs::path folder_;
  int threads_;
  std::function<void(const Progress&)> progress_;
  std::unique_ptr<VehicleWorld> world_;
  std::unique_ptr<Driver> driver_;
  std::optional<RunRecord> record_;
  Command command_;
  RunTotals totals_;
  ExtentWatch extent_;
  double speed_at_start_ = 0;          // [m/s] fastest body
  std::optional<Checkpoint> pending_;  ///< the newest, perhaps not in its file yet
  double last_checkpoint_ = -1;        ///< time of the one in the file [s]
  Clock::time_point written_;
  double terrain_s_ = 0, output_s_ = 0;
};

}  // namespace

std::vector<std::string> check_scenario(const fs::path& yaml, const Registry& registry) {
  return load_scenario(yaml, registry).notices;
}

RunSummary run_scenario(const fs::path& yaml, const Registry& registry, const RunOptions& o) {
  const ScenarioOverrides overrides{o.terrain, o.duration};
  load_scenario(yaml, registry, overrides);  // errors name the user's own files
  const std::vector<InputFile> inputs = collect_inputs(yaml);
  const FolderLock lock(o.out);
  std::error_code e;
  fs::remove(o.out / "checkpoint.h5", e);  // of an earlier run in this folder
  copy_inputs(inputs, o.out / "inputs");
  const fs::path copy = o.out / "inputs" / inputs.front().relative;
  const std::string text = resolved_text(collect_inputs(copy), overrides);
  {
    // What resume needs to find its way back; text, so that it survives whatever happens to run.h5.
    State names;
    std::string relative = inputs.front().relative.generic_string(), terrain = o.terrain.value_or("");
    double duration = o.duration.value_or(-1);
    names.field("scenario", relative);
    names.field("terrain", terrain);
    names.field("duration", duration);
    Checkpoint c;
    c.scenario = text;
    c.version = GROUSER_VERSION;
    c.state = names;
    write_checkpoint(o.out / "inputs" / "origin.h5", c);
  }
  return Run(load_scenario(copy, registry, overrides), text, o.out, o.threads, o.progress).fresh();
}

RunSummary resume_run(const fs::path& folder, const Registry& registry, int threads,
                      const std::function<void(const Progress&)>& progress) {
  if (!fs::is_directory(folder / "inputs"))
    throw ResultsError(folder.string() +
                       ": not a run folder (it has no inputs/); give the folder that `grouser run` has written");
  const FolderLock lock(folder);
  Checkpoint origin = read_checkpoint(folder / "inputs" / "origin.h5");
  std::string relative, terrain;
  double duration = -1;
  origin.state.rewind(State::Mode::load);
  origin.state.field("scenario", relative);
  origin.state.field("terrain", terrain);
  origin.state.field("duration", duration);
  ScenarioOverrides overrides;
  if (!terrain.empty()) overrides.terrain = terrain;
  if (duration > 0) overrides.duration = duration;
  const fs::path copy = folder / "inputs" / relative;
  const Checkpoint c = read_checkpoint(folder / "checkpoint.h5");
  if (c.scenario != origin.scenario || resolved_text(collect_inputs(copy), overrides) != origin.scenario)
    throw ResultsError(
        (folder / "checkpoint.h5").string() +
        ": checkpoint of another scenario than the one in inputs/; start the run again instead of resuming it");
  return Run(load_scenario(copy, registry, overrides), c.scenario, folder, threads, progress).resume(c);
}

}  // namespace grouser::vehicle
