// From runs to tables.
#include <algorithm>
#include <cmath>

#include "grouser/sdem/campaign.h"
#include "soil_text.h"

namespace grouser::sdem {

namespace {

constexpr int kSweeps = 200;  ///< of the estimate of empty cells

/// Means of what fell into the cells of one node.
struct Cells {
  explicit Cells(const Grid& g)
      : rows(g.u.count), columns(g.v.count), x(g.plane(), 0), z(g.plane(), 0), n(g.plane(), 0) {}
  std::size_t at(int i, int j) const {
    return static_cast<std::size_t>(i) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(j);
  }
  void add(int i, int j, double a, double b) {
    const std::size_t k = at(i, j);
    x[k] += a;
    z[k] += b;
    n[k] += 1;
  }
  void finish(Grid& g, std::size_t node);

  int rows, columns;
  std::vector<double> x, z, n;

 private:
  void estimate(std::vector<double>& v) const;
  void smooth(std::vector<double>& v) const;
};

/// Cells without an entry: each becomes the mean of its neighbours (discrete harmonic), known ones stay.
void Cells::estimate(std::vector<double>& v) const {
  std::vector<char> has(v.size());
  for (std::size_t k = 0; k < v.size(); ++k) has[k] = n[k] > 0;
  if (std::none_of(has.begin(), has.end(), [](char h) { return h; })) return;  // nothing was ever there: zero
  const auto mean_of_neighbours = [&](int i, int j, const std::vector<char>& valid, double& out) {
    double sum = 0;
    int count = 0;
    for (const auto& [di, dj] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      const int a = i + di, b = j + dj;
      if (a < 0 || b < 0 || a >= rows || b >= columns || !valid[at(a, b)]) continue;
      sum += v[at(a, b)];
      ++count;
    }
    if (count > 0) out = sum / count;
    return count > 0;
  };
  // First layer by layer from what is known, then relaxed.
  for (bool more = true; more;) {
    more = false;
    std::vector<char> next = has;
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j < columns; ++j)
        if (!has[at(i, j)] && mean_of_neighbours(i, j, has, v[at(i, j)])) next[at(i, j)] = more = true;
    has = std::move(next);
  }
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j < columns; ++j)
        if (!(n[at(i, j)] > 0)) mean_of_neighbours(i, j, has, v[at(i, j)]);
}

/// (1 2 1)/4 along both axes; at an end the value itself stands for the missing neighbour.
void Cells::smooth(std::vector<double>& v) const {
  const auto pass = [&](bool along_rows) {
    const std::vector<double> old = v;
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j < columns; ++j) {
        const int last = along_rows ? rows - 1 : columns - 1, here = along_rows ? i : j;
        const int low = std::max(here - 1, 0), high = std::min(here + 1, last);
        const double a = old[along_rows ? at(low, j) : at(i, low)], b = old[along_rows ? at(high, j) : at(i, high)];
        v[at(i, j)] = 0.25 * a + 0.5 * old[at(i, j)] + 0.25 * b;
      }
  };
  pass(true);
  pass(false);
}

void Cells::finish(Grid& g, std::size_t node) {
  for (std::size_t k = 0; k < n.size(); ++k)
    if (n[k] > 0) x[k] /= n[k], z[k] /= n[k];
  for (auto* v : {&x, &z}) {
    estimate(*v);
    smooth(*v);
  }
  for (std::size_t k = 0; k < n.size(); ++k) {
    const std::size_t to = node * g.plane() + k;
    g.x[to] = static_cast<float>(x[k]);
    g.z[to] = static_cast<float>(z[k]);
    g.known[to] = n[k] > 0 ? 1.0F : 0.0F;
  }
}

int nearest(const Axis& a, double x) {
  return std::clamp(static_cast<int>(std::lround((x - a.first) / a.step())), 0, a.count - 1);
}
bool within(const Axis& a, double x) { return x >= a.first && x <= a.last; }

/// Profile of a region in one window: highest cell with a grain in each column, and the sum over its grains.
struct Surface {
  explicit Surface(const Grid& g) : grid(&g), columns(static_cast<std::size_t>(g.v.count)) {}
  void add(double dx, double dz, double vx, double vz) {
    if (!within(grid->v, dx) || !within(grid->u, dz)) return;
    Column& c = columns[static_cast<std::size_t>(nearest(grid->v, dx))];
    const int row = nearest(grid->u, dz);
    if (row < c.row) return;
    if (row > c.row) c = Column{row, 0, 0, 0};
    c.vx += vx;
    c.vz += vz;
    c.n += 1;
  }
  struct Column {
    int row = -1;
    double vx = 0, vz = 0, n = 0;
  };
  const Grid* grid;
  std::vector<Column> columns;
};

class Maker {
 public:
  Maker(const Campaign& c, Tables& t) : c_(c), t_(t) {}

  void node(std::size_t node, const RunRecord& r) {
    std::vector<Cells> cells;
    for (const Grid& g : t_.parts) cells.emplace_back(g);
    for (std::size_t k = 0; k < r.windows(); ++k) {
      std::vector<Surface> surfaces;
      for (std::size_t p = 0; p < 4; ++p) surfaces.emplace_back(t_.parts[p]);
      for (auto i = static_cast<std::size_t>(r.first[k]); i < static_cast<std::size_t>(r.first[k + 1]); ++i)
        for (Surface& s : surfaces) s.add(r.dx[i], r.dz[i], r.vx[i], r.vz[i]);
      for (std::size_t p = 0; p < 4; ++p)
        for (std::size_t j = 0; j < surfaces[p].columns.size(); ++j) {
          const Surface::Column& s = surfaces[p].columns[j];
          if (s.row >= 0) cells[p].add(s.row, static_cast<int>(j), s.vx / s.n, s.vz / s.n);
        }
      wheel(r, k, surfaces[1], cells[4], cells[5]);
    }
    for (std::size_t p = 0; p < t_.parts.size(); ++p) cells[p].finish(t_.parts[p], node);
  }

 private:
  /// Pressure round the wheel in one window, and where the rim is touched.
  void wheel(const RunRecord& r, std::size_t window, const Surface& top_soil, Cells& bottom, Cells& top) const {
    constexpr int n = RunRecord::kBins;
    const double bin = 2 * pi / n * c_.radius, mean = 0.5 * (c_.soil.smallest + c_.soil.largest);
    const int half = std::max(1, static_cast<int>(std::lround(0.5 * mean / bin))),
              alone = std::max(1, static_cast<int>(std::ceil(c_.soil.largest / bin)));
    std::vector<double> fx(n), fz(n);
    std::vector<char> touched(n, 0);
    for (int b = 0; b < n; ++b) {
      const std::size_t k = window * n + static_cast<std::size_t>(b);
      fx[static_cast<std::size_t>(b)] = r.bin_fx[k];
      fz[static_cast<std::size_t>(b)] = r.bin_fz[k];
      touched[static_cast<std::size_t>(b)] = r.bin_fx[k] != 0 || r.bin_fz[k] != 0;
    }
    const auto wrap = [](int b) { return static_cast<std::size_t>((b + n) % n); };
    // A contact too far from every other one makes no pressure.
    const std::vector<char> all = touched;
    for (int b = 0; b < n; ++b) {
      bool company = false;
      for (int d = 1; d <= alone && !company; ++d) company = all[wrap(b + d)] || all[wrap(b - d)];
      if (!company) touched[wrap(b)] = 0;
    }
    std::vector<double> px(n, 0), pz(n, 0);
    std::vector<char> rim(n, 0);
    const double area = (2 * half + 1) * bin * c_.width;
    for (int b = 0; b < n; ++b) {
      if (!touched[wrap(b)]) continue;
      for (int d = -half; d <= half; ++d) {
        px[wrap(b + d)] += fx[wrap(b)] / area;
        pz[wrap(b + d)] += fz[wrap(b)] / area;
        rim[wrap(b + d)] = 1;
      }
    }
    const Grid &low = t_.part(Part::wheel_bottom), &high = t_.part(Part::wheel_top);
    const auto bin_of = [&](double angle) { return wrap(static_cast<int>(std::floor((angle + pi) / (2 * pi) * n))); };
    const double height = r.height[window];
    if (within(low.u, height))
      for (int j = 0; j < low.v.count; ++j)
        if (const std::size_t b = bin_of(low.v.at(j)); rim[b]) bottom.add(nearest(low.u, height), j, px[b], pz[b]);
    for (int j = 0; j < high.v.count; ++j) {
      const double theta = high.v.at(j);  // from the highest point
      const std::size_t b = bin_of(theta >= 0 ? pi - theta - 1e-9 : -pi - theta);
      if (!rim[b]) continue;
      const Grid& soil = *top_soil.grid;
      const Surface::Column& s =
          top_soil.columns[static_cast<std::size_t>(nearest(soil.v, c_.radius * std::sin(theta)))];
      if (s.row >= 0) top.add(nearest(high.u, soil.u.at(s.row)), j, px[b], pz[b]);
    }
  }

  const Campaign& c_;
  Tables& t_;
};

}  // namespace

Tables make_tables(const Campaign& c, const std::vector<CampaignRun>& runs,
                   const std::function<RunRecord(std::size_t run)>& record) {
  Tables t;
  t.title = c.title;
  t.source = c.source;
  t.wheel = c.wheel;
  t.radius = c.radius;
  t.width = c.width;
  t.bed_depth = c.bed_depth;
  t.soil = soil_text(c.soil);
  t.w = c.w;
  t.vx = c.vx;
  t.vz = c.vz;
  GridSettings g;
  g.reach = c.reach;
  g.cell = g.height = c.cell;
  g.lowest = runs.front().low;
  g.highest = runs.front().high;
  t.shape(g);
  Maker maker(c, t);
  for (std::size_t k = 0; k < runs.size(); ++k) {
    maker.node(k, record(k));
    t.inputs += runs[k].inputs + "---\n";
  }
  return t;
}

}  // namespace grouser::sdem
