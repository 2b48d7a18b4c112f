#include "soil_run.h"

#include <fmt/core.h>

#include <chrono>
#include <fstream>
#include <mutex>

#include "dem_table.h"
#include "grouser/terrain/checkpoint.h"
#include "grouser/terrain/csv.h"
#include "grouser/terrain/parallel.h"
#include "grouser/terrain/recorder.h"
#include "progress.h"
#include "whole_file.h"

namespace grouser::app {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

/// Beside the curve: what it is the result of. Written last, so that its presence says that the case is complete.
std::string meta_of(const SoilCase& c, const dem::SoilTest& test, const dem::Packing& bed, double wall) {
  const dem::Counters n = test.counters();
  std::string out = fmt::format(
      "case: {}\ninputs_hash: {}\nversion: {}\ngrains: {}\nbed: {{height: {:.6g} m, bulk_density: {:.6g} kg/m^3, "
      "grain_density: {:.6g} kg/m^3, rms_speed_when_poured: {:.3g} m/s}}\nsimulated: {:.9g} s\nsteps: {}\n"
      "wall_time: {:.1f} s   # of the last start\ninputs: |\n",
      c.name, c.hash, GROUSER_VERSION, n.grains, bed.height, bed.bulk_density,
      bed.grains.empty() ? 0 : bed.grains[0].density, bed.residual_speed, test.time(), n.steps, wall);
  const std::size_t at = out.find("inputs: |");
  std::string notes;
  for (const auto& [name, value] : test.notes()) notes += fmt::format("{}: {:.6g}\n", name, value);
  out.insert(at, notes);
  std::size_t from = 0;
  while (from < c.inputs.size()) {
    const std::size_t end = c.inputs.find('\n', from);
    out += "  " + c.inputs.substr(from, end - from) + "\n";
    from = end + 1;
  }
  return out;
}

dem::Table read_curve(const fs::path& file) {
  FileErrors errors(file);
  const CsvRecords csv = CsvRecords::read(file, errors);
  dem::Table t;
  t.columns = csv.columns;
  for (const auto& r : csv.rows) {
    std::vector<double> values;
    for (const CsvCell& cell : r.cells) {
      const auto x = parse_number(cell.text);
      if (!x) errors.add(r.line, cell.column, "'" + cell.text + "' is not a number");
      values.push_back(x.value_or(0));
    }
    t.rows.push_back(std::move(values));
  }
  errors.check();
  return t;
}

/// The hash of a finished case; "" when there is none.
std::string finished_hash(const fs::path& meta) {
  if (!fs::exists(meta)) return "";
  const ConfigDocument doc = ConfigDocument::from_file(meta);
  doc.check();
  return doc.root().text_or("inputs_hash", "");
}

/// Work in grain steps over all cases, for the line of progress.
class Ledger {
 public:
  Ledger(std::size_t cases, const SoilRunOptions& o)
      : line_(o.quiet), head_(o.head), then_(o.then), done_(cases, 0.0), total_(cases, 0.0), begin_(Clock::now()) {}
  void expect(std::size_t k, double work) { total_[k] = work; }
  void skip() { ++finished_; }
  void update(std::size_t k, const std::string& name, double time, double done, double total) {
    const std::lock_guard lock(mutex_);
    if (start_.size() <= k) start_.resize(done_.size(), -1);
    if (start_[k] < 0) start_[k] = done;
    done_[k] = done - start_[k];
    total_[k] = total - start_[k];
    double d = 0, t = 0;
    for (std::size_t i = 0; i < done_.size(); ++i) d += done_[i], t += total_[i];
    if (d < t)
      line_.update(fmt::format("{}{} of {}: {} at {:.3f} s;", head_, finished_ + 1, done_.size(), name, time), 1e-6 * d,
                   1e-6 * t * (1 + then_), since(begin_), "M grain steps");
  }
  void finish(std::size_t k) {
    const std::lock_guard lock(mutex_);
    done_[k] = total_[k];
    ++finished_;
  }

 private:
  ProgressLine line_;
  std::string head_;
  double then_;
  std::mutex mutex_;
  std::vector<double> done_, total_, start_;
  std::size_t finished_ = 0;
  Clock::time_point begin_;
};

/// Grains and simulated time before anything is poured: grains of mean volume fill 0.52 of the space.
double expected_work(const SoilCase& c) {
  const double a = c.soil.smallest, b = c.soil.largest;
  const double mean_cube = (a + b) * (a * a + b * b) / 4;
  const auto grains = [&](double volume) { return 0.52 * volume / (pi / 6 * mean_cube); };
  if (const auto* t = std::get_if<dem::ShearSettings>(&c.test))
    return grains(t->side * t->side * t->height) * (t->displacement / t->rate + t->rest) / c.soil.dt;
  if (const auto* t = std::get_if<dem::ReposeSettings>(&c.test))
    return grains(t->base_x * t->base_y * t->height) * t->duration / c.soil.dt;
  if (const auto* t = std::get_if<dem::OedometerSettings>(&c.test))
    return grains(t->side * t->side * t->height) * t->hold * static_cast<double>(t->pressures.size()) / c.soil.dt;
  if (const auto* t = std::get_if<dem::TriaxialSettings>(&c.test))
    return grains(t->side * t->side * t->height) * (t->strain / t->strain_rate + t->rest) / c.soil.dt;
  const auto& t = std::get<dem::SinkageSettings>(c.test);
  return grains(t.bin_x * t.bin_y * t.depth) * ((t.sinkage + 0.005) / t.rate + 0.3) / c.soil.dt;
}

SoilCaseResult run_case(const SoilJob& job, std::size_t k, const SoilRunOptions& o, Ledger& ledger) {
  const SoilCase& c = *job.spec;
  const fs::path csv = job.folder / (c.name + ".csv"), meta = job.folder / (c.name + ".yaml"),
                 checkpoint = job.folder / (c.name + ".checkpoint.h5");
  const auto begin = Clock::now();
  const dem::Packing bed = dem::cached_packing(c.poured, c.pouring(), o.beds, {}, o.checkpoint_every);
  const std::unique_ptr<dem::SoilTest> test = c.make(bed);
  if (fs::exists(checkpoint)) {
    Checkpoint saved = read_checkpoint(checkpoint);
    // A checkpoint of other inputs is what an earlier, stopped run of another file left: it is of no use here.
    if (saved.scenario == c.inputs && saved.version == GROUSER_VERSION) {
      test->traverse(saved.state);
      saved.state.finish();
    }
  }
  const double grains = static_cast<double>(test->counters().grains);
  const auto save = [&] {
    Checkpoint now;
    now.scenario = c.inputs;
    now.version = GROUSER_VERSION;
    now.time = test->time();
    now.frames = test->table().rows.size();
    test->traverse(now.state);
    write_checkpoint(checkpoint, now);
  };
  save();  // a full disk is found before anything is computed
  auto last = Clock::now();
  for (bool more = true; more;) {
    more = test->advance();
    const double scale = grains / c.soil.dt;
    ledger.update(k, c.name, test->time(), test->time() * scale, (test->time() + test->left()) * scale);
    if (more && since(last) > o.checkpoint_every) {
      save();
      last = Clock::now();
    }
  }
  write_whole_file(csv, csv_text(test->table()));
  write_whole_file(meta, meta_of(c, *test, bed, since(begin)));
  fs::remove(checkpoint);
  ledger.finish(k);
  // As stored: the same whether it was computed now or before.
  return {&c, true, "", read_curve(csv)};
}

}  // namespace

std::vector<SoilCaseResult> run_soil_cases(const std::vector<SoilJob>& jobs, const SoilRunOptions& o,
                                           const std::function<void(const std::vector<SoilCaseResult>&)>& finished) {
  std::vector<SoilCaseResult> results(jobs.size());
  std::vector<Diagnostic> other;
  Ledger ledger(jobs.size(), o);
  std::vector<std::size_t> missing;
  for (std::size_t k = 0; k < jobs.size(); ++k) {
    const SoilCase& c = *jobs[k].spec;
    results[k].spec = &c;
    const fs::path meta = jobs[k].folder / (c.name + ".yaml");
    const std::string had = finished_hash(meta);
    if (had == c.hash) {
      results[k].table = read_curve(jobs[k].folder / (c.name + ".csv"));
      results[k].done = true;
      ledger.skip();
      continue;
    }
    if (!had.empty() && !o.overwrite)
      other.push_back(
          {meta.string(), 0, 0, "holds the results of other inputs; use --overwrite, or another folder with --out"});
    missing.push_back(k);
    ledger.expect(k, expected_work(c));
  }
  if (!other.empty()) throw ConfigError(other);
  if (missing.size() < jobs.size() && !o.quiet && o.head.empty())
    fmt::print(stderr, "{} of {} cases are finished already\n", jobs.size() - missing.size(), jobs.size());
  std::mutex one;
  parallel_for(static_cast<int>(missing.size()), o.threads, [&](int i) {
    const std::size_t k = missing[static_cast<std::size_t>(i)];
    SoilCaseResult r;
    try {
      r = run_case(jobs[k], k, o, ledger);
    } catch (const dem::DemError& e) {
      // Other cases go on.
      r = {jobs[k].spec, false, e.what(), {}};
    }
    const std::lock_guard lock(one);
    results[k] = std::move(r);
    if (finished) finished(results);
  });
  return results;
}

}  // namespace grouser::app
