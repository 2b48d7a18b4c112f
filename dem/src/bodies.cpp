#include "bodies.h"

#include <algorithm>
#include <cmath>

namespace grouser::dem {

namespace {

/// Distance of grains from a plane; positions along periodic axes, to which planes are square, do not enter.
template <class R>
struct PlaneFrame {
  Vec3 normal, arm;
  double n[3], c = 0;
  PlaneFrame(const Surface& s, const Body& body, const Space<R>& space)
      : normal(body.X.q * s.shape.normal()), arm(body.X.q * s.shape.point()) {
    const Vec3 from = body.X.p + arm - space.domain().lo;
    for (int k = 0; k < 3; ++k) {
      n[k] = normal[k] * space.unit(k);
      c += normal[k] * from[k];
    }
  }
  double distance(const Grain<R>& g) const {
    return n[0] * static_cast<double>(g.p[0]) + n[1] * static_cast<double>(g.p[1]) +
           n[2] * static_cast<double>(g.p[2]) - c;
  }
};

}  // namespace

template <class R>
double Bodies<R>::fastest() const {
  double v = 0;
  for (const Surface& s : surfaces) {
    const Body& b = bodies[static_cast<std::size_t>(s.body)];
    const double turn = b.V.w.norm();
    v = std::max(v, b.V.v.norm() + (turn > 0 ? turn * s.shape.extent() : 0));
  }
  return v;
}

template <class R>
void Bodies<R>::collect(const Part& p, std::size_t count, std::vector<Known>& into) {
  for (std::size_t s = 0; s < p.runs.size(); ++s)
    for (std::size_t b = p.runs[s].first; b < p.runs[s].last; ++b)
      for (std::size_t l = 0; l < kBlock; ++l) {
        const WallBlock<R>& block = p.blocks[b];
        const std::uint32_t g = block.i[l] / kUnit;
        if (g < count && block.delta[l] > 0)
          into.push_back({static_cast<std::uint32_t>(s), g, block.part[l], static_cast<std::uint32_t>(l), &block});
      }
}

template <class R>
void Bodies<R>::renumber(const std::vector<std::uint32_t>& moved_to, std::size_t chunks) {
  before_.swap(parts_);
  parts_.clear();
  parts_.resize(chunks);
  known_.clear();
  for (const Part& p : before_) collect(p, moved_to.size(), known_);
  for (Known& k : known_) k.grain = moved_to[k.grain];
  std::stable_sort(known_.begin(), known_.end());
}

template <class R>
void Bodies<R>::forget(const std::vector<std::uint8_t>& marked) {
  for (Part& p : parts_)
    for (WallBlock<R>& b : p.blocks)
      for (std::size_t l = 0; l < kBlock; ++l)
        if (b.i[l] / kUnit < marked.size() && marked[b.i[l] / kUnit]) b.delta[l] = -1;
}

template <class R>
Vec3 Bodies<R>::local(const Space<R>& space, const Grain<R>& g, const Body& b) const {
  Vec3 d = space.position(g) - b.X.p;
  for (int k = 0; k < 3; ++k)
    if (space.domain().periodic[static_cast<std::size_t>(k)]) {
      const double length = space.domain().hi[k] - space.domain().lo[k];
      d[k] -= length * std::round(d[k] / length);
    }
  return b.X.q.conjugate() * d;
}

template <class R>
void Bodies<R>::refresh(std::size_t c, const Space<R>& space, double dt, const Array<Grain<R>>& grains, Chunk& chunk,
                        std::size_t spare, const std::vector<std::uint32_t>& ids,
                        const std::vector<std::uint8_t>& material, const MaterialTable& table) {
  chunk.wall_reach = std::clamp(4 * kLasts * (chunk.speed + fastest()) * dt, 1e-5, kWallMargin);
  chunk.wall_then = chunk.travelled;
  chunk.surfaces_then = travelled;
  chunk.walls_due = 0;
  Part& p = parts_[c];
  const Part old = std::move(p);
  p = Part{};
  std::vector<Known> own;
  if (before_.empty()) collect(old, ids.size(), own);
  const std::vector<Known>& known = before_.empty() ? own : known_;
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    Run here;
    here.first = static_cast<std::uint32_t>(p.blocks.size());
    const Surface& surface = surfaces[s];
    const Body& body = bodies[static_cast<std::size_t>(surface.body)];
    const bool plane = surface.shape.kind() == ShapeKind::plane, cylinder = surface.shape.kind() == ShapeKind::cylinder;
    const PlaneFrame<R> frame(surface, body, space);
    int lane = kBlock;
    const auto add = [&](std::size_t g, std::uint32_t part) {
      if (lane == kBlock) {
        p.blocks.emplace_back();
        lane = 0;
      }
      WallBlock<R>& b = p.blocks.back();
      b.i[lane] = static_cast<std::uint32_t>(g) * kUnit +
                  static_cast<std::uint32_t>(table.index(material[ids[g]], surface.material));
      b.part[lane] = part;
      b.delta[lane] = -1;
      b.curvature[lane] = static_cast<R>(surface.shape.curvature(part));
      const Known key{static_cast<std::uint32_t>(s), static_cast<std::uint32_t>(g), part, 0, nullptr};
      for (auto k = std::lower_bound(known.begin(), known.end(), key); k != known.end() && !(key < *k); ++k) {
        if (k->part != part) continue;
        const WallBlock<R>& from = *k->block;
        for (int q = 0; q < 3; ++q) {
          b.s[q][lane] = from.s[q][k->lane];
          b.t[q][lane] = from.t[q][k->lane];
          b.n[q][lane] = from.n[q][k->lane];
        }
        b.delta[lane] = from.delta[k->lane];
        b.past.copy(static_cast<std::size_t>(lane), from.past, k->lane, R(1));
        break;
      }
      ++lane;
    };
    for (std::size_t g = chunk.first; g < chunk.last; ++g) {
      if (grains[g].im == 0) continue;
      const double wide = double(grains[g].r) + chunk.wall_reach;
      if (plane) {
        if (frame.distance(grains[g]) <= wide) add(g, 0);
        continue;
      }
      const Vec3 x = local(space, grains[g], body);
      const double bound = surface.shape.extent() + wide;
      if (!cylinder && x.squaredNorm() > bound * bound) continue;
      surface.shape.each_part_near(x, [&](std::uint32_t part) {
        if (surface.shape.distance_to(part, x) <= wide) add(g, part);
      });
    }
    if (here.first != p.blocks.size())
      for (; lane < kBlock; ++lane) {
        WallBlock<R>& b = p.blocks.back();
        b.i[lane] = static_cast<std::uint32_t>(spare) * kUnit;
        b.delta[lane] = -1;
      }
    here.last = static_cast<std::uint32_t>(p.blocks.size());
    p.runs.push_back(here);
  }
  p.blocks.shrink_to_fit();
  derive(p, ids.size());
}

/// Facets beside the contacts, and which grains have more than one.
template <class R>
void Bodies<R>::derive(Part& p, std::size_t count) const {
  p.facets.clear();
  p.groups.clear();
  p.facets_of.clear();
  p.groups_of.clear();
  p.was.clear();
  for (std::size_t s = 0; s < p.runs.size(); ++s) {
    const Shape& shape = surfaces[s].shape;
    Run facets, groups;
    facets.first = static_cast<std::uint32_t>(p.facets.size());
    groups.first = static_cast<std::uint32_t>(p.groups.size());
    const bool mesh = shape.kind() == ShapeKind::mesh;
    if (mesh || shape.kind() == ShapeKind::spheres)
      for (std::uint32_t at = p.runs[s].first; at < p.runs[s].last; ++at) {
        const WallBlock<R>& b = p.blocks[at];
        FacetBlock& to = p.facets.emplace_back();
        for (std::size_t l = 0; l < kBlock; ++l) {
          const Facet& f = shape.facet(b.part[l]);
          for (std::size_t k = 0; k < FacetField::count; ++k) to.field[k][l] = f[k];
          const std::uint32_t lane = at * kBlock + static_cast<std::uint32_t>(l), grain = b.i[l] / kUnit;
          if (!mesh || grain >= count || lane == p.runs[s].first * kBlock) continue;
          const std::uint32_t before = lane - 1;
          if (p.blocks[before / kBlock].i[before % kBlock] / kUnit != grain) continue;
          if (p.groups.size() > groups.first && p.groups.back().last == lane)
            p.groups.back().last = lane + 1;
          else
            p.groups.push_back({before, lane + 1});
        }
      }
    facets.last = static_cast<std::uint32_t>(p.facets.size());
    groups.last = static_cast<std::uint32_t>(p.groups.size());
    for (std::uint32_t g = groups.first; g < groups.last; ++g)
      for (std::uint32_t k = p.groups[g].first; k < p.groups[g].last; ++k)
        p.was.push_back(p.blocks[k / kBlock].delta[k % kBlock] > 0);
    p.facets_of.push_back(facets);
    p.groups_of.push_back(groups);
  }
}

template <class R>
SurfaceWork<R> Bodies<R>::work(const Surface& s, const Space<R>& space, const Array<Grain<R>>& grains) const {
  const Body& body = bodies[static_cast<std::size_t>(s.body)];
  SurfaceWork<R> w{};
  w.grains = grains.data();
  w.kind = s.shape.kind();
  const Mat3 turn = body.X.q.toRotationMatrix();
  for (int k = 0; k < 3; ++k) {
    // Along periodic axes from the nearest whole place, so that differences wrap by themselves.
    w.unit[k] = space.unit(k);
    w.from[k] = body.X.p[k] - space.domain().lo[k];
    if (space.domain().periodic[static_cast<std::size_t>(k)]) {
      const double length = space.domain().hi[k] - space.domain().lo[k];
      const double units = (w.from[k] - length * std::floor(w.from[k] / length)) / w.unit[k], whole = std::floor(units);
      w.origin[k] = static_cast<Int<R>>(static_cast<std::uint64_t>(whole));
      w.from[k] = (units - whole) * w.unit[k];
    }
    for (int j = 0; j < 3; ++j) w.turn[k][j] = turn(k, j);
  }
  w.radius = s.shape.radius();
  w.half_width = s.shape.half_width();
  return w;
}

template <class R>
void Bodies<R>::geometry(std::size_t c, const Space<R>& space, const Array<Grain<R>>& grains, std::size_t count,
                         const KernelOf<R>& kernel) {
  Part& p = parts_[c];
  std::uint8_t* was = p.was.data();
  for (std::size_t s = 0; s < p.runs.size(); ++s) {
    const Run r = p.runs[s], groups = p.groups_of[s];
    if (r.first == r.last) continue;
    if (surfaces[s].shape.kind() == ShapeKind::plane) {
      plane_geometry(surfaces[s], p, r, space, grains, count);
      continue;
    }
    kernel.touch(work(surfaces[s], space, grains), p.blocks.data() + r.first, p.blocks.data() + r.last,
                 p.facets.data() + p.facets_of[s].first);
    WallBlock<R>& last = p.blocks[r.last - 1];
    for (std::size_t l = 0; l < kBlock; ++l)
      if (last.i[l] / kUnit >= count) last.delta[l] = -1;
    // From a lane of the contacts to that of its facet.
    const std::uint32_t shift = (r.first - p.facets_of[s].first) * kBlock;
    for (std::uint32_t g = groups.first; g < groups.last; ++g) {
      const Group lanes = p.groups[g];
      std::uint8_t* before = was;
      int touching = 0;
      bool changed = false;
      for (std::uint32_t k = lanes.first; k < lanes.last; ++k, ++was) {
        const bool now = p.blocks[k / kBlock].delta[k % kBlock] > 0;
        touching += now;
        changed = changed || now != (*was != 0);
      }
      if (touching > 1) one_contact_per_place(surfaces[s], p, lanes, shift);
      if (changed) take_over(p, lanes, before);
    }
  }
}

template <class R>
void Bodies<R>::plane_geometry(const Surface& s, Part& p, Run r, const Space<R>& space, const Array<Grain<R>>& grains,
                               std::size_t count) {
  const Body& body = bodies[static_cast<std::size_t>(s.body)];
  const PlaneFrame<R> frame(s, body, space);
  for (std::uint32_t at = r.first; at < r.last; ++at) {
    WallBlock<R>& b = p.blocks[at];
    double d[kBlock];
    for (int l = 0; l < kBlock; ++l) {
      const std::size_t place = b.i[l] / kUnit;
      const Grain<R>& g = grains[place];
      d[l] = place < count ? static_cast<double>(g.r) - frame.distance(g) : -1;
    }
    for (int l = 0; l < kBlock; ++l) b.delta[l] = static_cast<R>(d[l]);
    for (int k = 0; k < 3; ++k) {
      const R n = static_cast<R>(-frame.normal[k]), arm = static_cast<R>(frame.arm[k]);
      for (int l = 0; l < kBlock; ++l) b.n[k][l] = n;
      for (int l = 0; l < kBlock; ++l) b.at[k][l] = arm;
    }
  }
}

/// A point on an edge or a corner belongs to several triangles; the deepest contact of each place stays.
template <class R>
void Bodies<R>::one_contact_per_place(const Surface& s, Part& p, Group g, std::uint32_t shift) const {
  const auto delta = [&p](std::uint32_t k) -> R& { return p.blocks[k / kBlock].delta[k % kBlock]; };
  const auto distance = [&](std::uint32_t k) { return p.facets[(k - shift) / kBlock].distance[(k - shift) % kBlock]; };
  std::vector<std::uint32_t>& touching = p.kept;
  touching.clear();
  for (std::uint32_t k = g.first; k < g.last; ++k)
    if (delta(k) > 0) touching.push_back(k);
  if (touching.size() < 2) return;
  for (std::size_t k = 1; k < touching.size(); ++k)
    for (std::size_t m = k; m > 0 && distance(touching[m]) < distance(touching[m - 1]); --m)
      std::swap(touching[m], touching[m - 1]);
  std::size_t kept = 1;
  constexpr double kSame = 1e-8;  // [m]
  for (std::size_t k = 1; k < touching.size(); ++k) {
    const std::uint32_t at = touching[k] - shift;
    const FacetBlock& f = p.facets[at / kBlock];
    const Vec3 q(f.point[0][at % kBlock], f.point[1][at % kBlock], f.point[2][at % kBlock]);
    bool taken = false;
    for (std::size_t o = 0; o < kept && !taken; ++o) {
      const std::uint32_t part = p.blocks[touching[o] / kBlock].part[touching[o] % kBlock];
      const Facet& other = s.shape.facet(part);
      double off = 0;
      for (std::size_t c = 0; c < 3; ++c)
        off += other[FacetField::normal + c] * (q[static_cast<int>(c)] - other[FacetField::corner + c]);
      taken = std::fabs(off) < kSame && (s.shape.nearest_on(part, q) - q).squaredNorm() < kSame * kSame;
    }
    if (taken)
      delta(touching[k]) = -1;
    else
      touching[kept++] = touching[k];
  }
}

/// A contact that goes over from one triangle to its neighbour takes its history along.
template <class R>
void Bodies<R>::take_over(Part& p, Group g, std::uint8_t* was) const {
  const auto block = [&p](std::uint32_t k) -> WallBlock<R>& { return p.blocks[k / kBlock]; };
  const auto touches = [&](std::uint32_t k) { return block(k).delta[k % kBlock] > 0; };
  for (std::uint32_t k = g.first; k < g.last; ++k) {
    if (!touches(k) || was[k - g.first]) continue;
    for (std::uint32_t o = g.first; o < g.last; ++o) {
      if (touches(o) || !was[o - g.first]) continue;
      WallBlock<R>&to = block(k), &from = block(o);
      const std::size_t l = k % kBlock, m = o % kBlock;
      double cosine = 0;
      for (int c = 0; c < 3; ++c) cosine += double(to.n[c][l]) * double(from.n[c][m]);
      if (cosine < 0.9) continue;
      for (int c = 0; c < 3; ++c) {
        to.s[c][l] = from.s[c][m];
        to.t[c][l] = from.t[c][m];
        from.s[c][m] = from.t[c][m] = 0;
      }
      to.past.copy(l, from.past, m, R(1));
      from.past.clear(m);
      was[o - g.first] = 0;  // nobody takes it twice
      break;
    }
  }
  for (std::uint32_t k = g.first; k < g.last; ++k) was[k - g.first] = touches(k);
}

template <class R>
void Bodies<R>::move(Body& b, double dt, const Vec3& gravity) {
  if (b.set.free) {
    const Vec3 f = b.report.force + b.set.force + b.set.mass * gravity;
    const Mat3 turn = b.X.q.toRotationMatrix();
    const Mat3 inertia = turn * b.set.inertia.asDiagonal() * turn.transpose();
    const Vec3 a = f / b.set.mass;
    const Vec3 t = b.report.torque + b.set.torque - b.V.w.cross(inertia * b.V.w);
    // Locked directions take no part: the others move as if these were held by a bearing.
    Mat3 held = inertia;
    Vec3 rest = t;
    for (int k = 0; k < 3; ++k)
      if (b.set.locked[3 + static_cast<std::size_t>(k)]) {
        held.row(k).setZero();
        held.col(k).setZero();
        held(k, k) = 1;
        rest[k] = 0;
      }
    const Vec3 alpha = held.inverse() * rest;
    for (int k = 0; k < 3; ++k) {
      if (!b.set.locked[static_cast<std::size_t>(k)]) b.V.v[k] += a[k] * dt;
      if (!b.set.locked[3 + static_cast<std::size_t>(k)]) b.V.w[k] += alpha[k] * dt;
    }
  }
  b.X.p += b.V.v * dt;
  const double angle = b.V.w.norm() * dt;
  if (angle > 0) b.X.q = (Quat(Eigen::AngleAxisd(angle, Eigen::Vector3d(b.V.w.normalized()))) * b.X.q).normalized();
}

template <class R>
void Bodies<R>::finish(double dt, const Vec3& gravity, bool begun) {
  std::vector<Vec3> force(bodies.size(), Vec3::Zero()), torque(bodies.size(), Vec3::Zero());
  for (Body& b : bodies) b.report.contacts = 0;
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    SurfaceReport& report = surfaces[s].report;
    const auto at = static_cast<std::size_t>(surfaces[s].body);
    Body& body = bodies[at];
    report.force = report.torque = Vec3::Zero();
    report.contacts = 0;
    for (const Part& p : parts_) {
      report.force += Vec3(p.sums[s].force[0], p.sums[s].force[1], p.sums[s].force[2]);
      report.torque += Vec3(p.sums[s].torque[0], p.sums[s].torque[1], p.sums[s].torque[2]);
      report.contacts += p.sums[s].contacts;
    }
    report.impulse += report.force * dt;
    report.angular_impulse += report.torque * dt;
    force[at] += report.force;
    torque[at] += report.torque;
    body.report.contacts += report.contacts;
  }
  travelled += fastest() * dt;
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    Body& b = bodies[k];
    // For the ledger: the way of a step, with the mean of the forces at its ends.
    if (begun)
      b.given -= 0.5 * dt * ((force[k] + b.report.force).dot(b.V.v) + (torque[k] + b.report.torque).dot(b.V.w));
    b.report.force = force[k];
    b.report.torque = torque[k];
    b.report.impulse += force[k] * dt;
    b.report.angular_impulse += torque[k] * dt;
    const Twist before = b.V;
    move(b, dt, gravity);
    // Forces act on the mean of the velocities before and after them.
    const Vec3 v = 0.5 * (before.v + b.V.v), w = 0.5 * (before.w + b.V.w);
    b.report.work -= (force[k].dot(v) + torque[k].dot(w)) * dt;
    for (Surface& s : surfaces)
      if (static_cast<std::size_t>(s.body) == k) s.report.work -= (s.report.force.dot(v) + s.report.torque.dot(w)) * dt;
  }
}

template <class R>
std::size_t Bodies<R>::bytes() const {
  std::size_t n = sizeof(Known) * known_.capacity();
  for (const Part& p : parts_)
    n += sizeof(WallBlock<R>) * p.blocks.capacity() + sizeof(FacetBlock) * p.facets.capacity() +
         sizeof(Group) * p.groups.capacity();
  return n;
}

template class Bodies<float>;
template class Bodies<double>;

}  // namespace grouser::dem
