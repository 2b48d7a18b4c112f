// Packings on disk: an HDF5 file in the form of a run, every number readable as it stands.
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cmath>
#include <map>
#include <mutex>

#include "grouser/terrain/file_target.h"
#include "grouser/terrain/recorder.h"
#include "packing.h"

namespace grouser::dem {

namespace {

namespace fs = std::filesystem;

/// Volume of the part of a sphere below height h above its lowest point.
double cap_volume(double r, double h) {
  h = std::min(std::max(h, 0.0), 2 * r);
  return pi * h * h * (r - h / 3);
}

struct Columns {
  std::vector<double> position, velocity, spin, radius, density, material, frozen;
};

Columns columns_of(const Packing& p) {
  Columns c;
  for (const GrainState& g : p.grains) {
    for (int k = 0; k < 3; ++k) {
      c.position.push_back(g.x[k]);
      c.velocity.push_back(g.v[k]);
      c.spin.push_back(g.w[k]);
    }
    c.radius.push_back(g.radius);
    c.density.push_back(g.density);
    c.material.push_back(g.material);
    c.frozen.push_back(g.frozen);
  }
  return c;
}

std::string content_hash(Packing p) {
  Columns c = columns_of(p);
  State s;
  s.field("inputs", p.inputs);
  double numbers[] = {p.lx, p.ly, p.height, p.bulk_density, p.settle_time, p.residual_speed};
  s.reals("numbers", numbers, 6);
  s.field("walls", p.walls);
  if (p.slab) {
    bool slab = true;
    s.field("slab", slab);
  }
  for (auto* v : {&c.position, &c.velocity, &c.spin, &c.radius, &c.density, &c.material, &c.frozen})
    s.field("grains", *v);
  return s.hash_text();
}

}  // namespace

std::vector<double> porosity_profile(const Packing& p, int layers) {
  const double thick = p.height / layers, volume = thick * p.lx * p.ly;
  std::vector<double> solid(static_cast<std::size_t>(layers), 0.0);
  for (const GrainState& g : p.grains) {
    const double low = g.x[2] - g.radius;
    const int first = std::max(0, static_cast<int>(low / thick)),
              last = std::min(layers - 1, static_cast<int>((low + 2 * g.radius) / thick));
    for (int k = first; k <= last; ++k)
      solid[static_cast<std::size_t>(k)] +=
          cap_volume(g.radius, (k + 1) * thick - low) - cap_volume(g.radius, k * thick - low);
  }
  for (double& s : solid) s = 1 - s / volume;
  return solid;
}

void write_bed(const Packing& p, const fs::path& file, const std::string& title) {
  const FileTarget target = file_target(file);
  if (target.stream) throw ResultsError(file.string() + ": is a device or a pipe; HDF5 needs a file of its own");
  const fs::path part = target.path.string() + "." + std::to_string(::getpid()) + ".part";
  {
    Recorder out = Recorder::create(part, {"bed", p.inputs, title, "dem", "", 0});
    out.set_attribute("bed_format", 1.0);
    out.set_attribute("inputs_hash", hash_text(p.inputs));
    out.set_attribute("hash", content_hash(p));
    out.set_attribute("lx", p.lx);
    out.set_attribute("ly", p.ly);
    out.set_attribute("walls", p.walls ? 1.0 : 0.0);
    out.set_attribute("slab", p.slab ? 1.0 : 0.0);
    out.set_attribute("height", p.height);
    out.set_attribute("bulk_density", p.bulk_density);
    out.set_attribute("settle_time", p.settle_time);
    out.set_attribute("residual_speed", p.residual_speed);
    const Columns c = columns_of(p);
    const std::uint64_t n = p.grains.size();
    out.write_static({"position", "m", "centre of each grain", "W", 3}, c.position, {n, 3});
    out.write_static({"velocity", "m/s", "of each grain", "W", 3}, c.velocity, {n, 3});
    out.write_static({"spin", "rad/s", "of each grain", "W", 3}, c.spin, {n, 3});
    out.write_static({"radius", "m", "of each grain", "", 1}, c.radius, {n});
    out.write_static({"density", "kg/m^3", "of each grain", "", 1}, c.density, {n});
    out.write_static({"material", "1", "number of each grain's material", "", 1}, c.material, {n});
    out.write_static({"frozen", "1", "1: held in place", "", 1}, c.frozen, {n});
    const std::vector<double> porosity = porosity_profile(p, 16);
    out.write_static({"porosity", "1", "of equal layers from the bottom to the surface", "", 1}, porosity,
                     {porosity.size()});
    out.close();
  }
  std::error_code failed;
  fs::rename(part, target.path, failed);
  if (failed) throw ResultsError(file.string() + ": cannot be written: " + failed.message());
}

Packing read_bed(const fs::path& file) {
  const RunFile in(file);
  const auto fail = [&file](const std::string& what) { throw ResultsError(file.string() + ": " + what); };
  if (in.attributes().kind != "bed")
    fail("is a " + in.attributes().kind + ", not a bed; make one with 'grouser dem bed'");
  if (in.number("bed_format", 0) != 1) fail("is a bed of another version of grouser; make it again");
  const auto damaged = [&] { fail("is damaged: its content does not match its stored hash; make it again"); };
  Packing p;
  p.inputs = in.attributes().scenario;
  p.lx = in.number("lx", 0);
  p.ly = in.number("ly", 0);
  p.walls = in.number("walls", 0) != 0;
  p.slab = in.number("slab", 0) != 0;
  p.height = in.number("height", 0);
  p.bulk_density = in.number("bulk_density", 0);
  p.settle_time = in.number("settle_time", 0);
  p.residual_speed = in.number("residual_speed", 0);
  Columns c{in.read("position"), in.read("velocity"), in.read("spin"),  in.read("radius"),
            in.read("density"),  in.read("material"), in.read("frozen")};
  const std::size_t n = c.radius.size();
  if (c.position.size() != 3 * n || c.velocity.size() != 3 * n || c.spin.size() != 3 * n || c.density.size() != n ||
      c.material.size() != n || c.frozen.size() != n)
    damaged();
  for (std::size_t k = 0; k < n; ++k) {
    GrainState g;
    for (int a = 0; a < 3; ++a) {
      const std::size_t at = 3 * k + static_cast<std::size_t>(a);
      g.x[a] = c.position[at];
      g.v[a] = c.velocity[at];
      g.w[a] = c.spin[at];
    }
    g.radius = c.radius[k];
    g.density = c.density[k];
    g.material = static_cast<int>(c.material[k]);
    g.frozen = c.frozen[k] != 0;
    p.grains.push_back(g);
  }
  if (content_hash(p) != in.attribute("hash")) damaged();
  return p;
}

namespace {

/// Of several processes one holds it; a killed one lets go.
class Lock {
 public:
  explicit Lock(const fs::path& file) : fd_(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)) {
    held_ = fd_ >= 0 && ::flock(fd_, LOCK_EX | LOCK_NB) == 0;
  }
  ~Lock() {
    if (fd_ >= 0) ::close(fd_);
  }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;
  bool held() const { return held_; }

 private:
  int fd_;
  bool held_;
};

}  // namespace

Packing cached_packing(const SoilSettings& soil, const PourSettings& p, const fs::path& folder,
                       const Progress& progress, double every) {
  if (folder.empty()) return pour(soil, p, progress);
  const std::string inputs = inputs_text(soil) + inputs_text(p), name = hash_text(inputs);
  // Cases of one process that want the same packing wait for the first of them; other processes may pour it as well.
  static std::mutex all;
  static std::map<std::string, std::mutex> one;
  std::mutex* mine = nullptr;
  {
    const std::lock_guard lock(all);
    mine = &one[name];
  }
  const std::lock_guard lock(*mine);
  const fs::path file = folder / (name + ".h5");
  if (fs::exists(file)) {
    Packing stored = read_bed(file);
    if (stored.inputs == inputs) return stored;
  }
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) throw ResultsError(folder.string() + ": cannot be made: " + failed.message());
  const fs::path checkpoint = folder / (name + ".checkpoint.h5"), lock_file = folder / (name + ".lock");
  const Lock ours(lock_file);
  Packing made = ours.held() ? pour(soil, p, checkpoint, every, progress) : pour(soil, p, progress);
  write_bed(made, file, p.walls ? "grains poured into a box" : "periodic brick of poured grains");
  if (ours.held()) {
    fs::remove(checkpoint, failed);
    fs::remove(lock_file, failed);
  }
  return made;
}

}  // namespace grouser::dem
