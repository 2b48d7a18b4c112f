#include "bodies.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace grouser::dem {

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
void Bodies<R>::renumber(const std::vector<std::uint32_t>& moved_to) {
  for (WallBlock<R>& b : blocks_)
    for (std::uint32_t& i : b.i) {
      const std::uint32_t k = i / kUnit;
      if (k < moved_to.size()) i = moved_to[k] * kUnit + i % kUnit;
    }
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
void Bodies<R>::refresh(const Space<R>& space, double margin, const Array<Grain<R>>& grains,
                        const std::vector<Chunk>& chunks, const std::vector<std::uint32_t>& ids,
                        const std::vector<std::uint8_t>& material, const MaterialTable& table) {
  // Histories of the old list, by surface, grain and part.
  struct Key {
    std::uint32_t surface, grain, part;
    bool operator==(const Key& o) const { return surface == o.surface && grain == o.grain && part == o.part; }
  };
  struct Hash {
    std::size_t operator()(const Key& k) const {
      return (std::size_t{k.grain} * 0x9e3779b97f4a7c15ULL) ^ (std::size_t{k.part} << 20) ^ k.surface;
    }
  };
  std::unordered_map<Key, std::size_t, Hash> past;
  const std::size_t n = surfaces.size();
  for (std::size_t r = 0; r < runs_.size() && n > 0; ++r)
    for (std::size_t at = std::size_t{runs_[r].first} * kBlock; at < std::size_t{runs_[r].last} * kBlock; ++at) {
      const WallBlock<R>& b = blocks_[at / kBlock];
      const std::uint32_t g = b.i[at % kBlock] / kUnit;
      if (g < ids.size() && b.delta[at % kBlock] > 0)
        past[{static_cast<std::uint32_t>(r % n), g, b.part[at % kBlock]}] = at;
    }
  Array<WallBlock<R>> old;
  old.swap(blocks_);
  runs_.assign(chunks.size() * n, Run{});
  for (std::size_t c = 0; c < chunks.size(); ++c)
    for (std::size_t s = 0; s < n; ++s) {
      Run& here = runs_[c * n + s];
      here.first = static_cast<std::uint32_t>(blocks_.size());
      const Surface& surface = surfaces[s];
      const Body& body = bodies[static_cast<std::size_t>(surface.body)];
      const double extent = surface.shape.extent();
      int lane = kBlock;
      for (std::size_t g = chunks[c].first; g < chunks[c].last; ++g) {
        if (grains[g].im == 0) continue;
        const double wide = double(grains[g].r) + margin;
        const Vec3 x = local(space, grains[g], body);
        if (std::isfinite(extent) && surface.shape.kind() != ShapeKind::cylinder &&
            x.squaredNorm() > (extent + wide) * (extent + wide))
          continue;
        surface.shape.each_part_near(x, [&](std::uint32_t part) {
          if (surface.shape.touch(part, x).distance > wide) return;
          if (lane == kBlock) {
            blocks_.emplace_back();
            lane = 0;
          }
          WallBlock<R>& b = blocks_.back();
          b.i[lane] = static_cast<std::uint32_t>(g) * kUnit +
                      static_cast<std::uint32_t>(table.index(material[ids[g]], surface.material));
          b.part[lane] = part;
          const auto it = past.find({static_cast<std::uint32_t>(s), static_cast<std::uint32_t>(g), part});
          const bool known = it != past.end();
          const WallBlock<R>* from = known ? &old[it->second / kBlock] : nullptr;
          const std::size_t l = known ? it->second % kBlock : 0;
          for (int k = 0; k < 3; ++k) {
            b.s[k][lane] = known ? from->s[k][l] : 0;
            b.t[k][lane] = known ? from->t[k][l] : 0;
            b.n[k][lane] = known ? from->n[k][l] : 0;
          }
          b.delta[lane] = known ? from->delta[l] : -1;
          ++lane;
        });
      }
      if (here.first != blocks_.size())
        for (; lane < kBlock; ++lane) {
          WallBlock<R>& b = blocks_.back();
          b.i[lane] = static_cast<std::uint32_t>(ids.size()) * kUnit;
          b.part[lane] = 0;
          b.delta[lane] = -1;
          for (int k = 0; k < 3; ++k) b.s[k][lane] = b.t[k][lane] = b.n[k][lane] = 0;
        }
      here.last = static_cast<std::uint32_t>(blocks_.size());
    }
}

template <class R>
void Bodies<R>::geometry(std::size_t chunk, const Space<R>& space, const Array<Grain<R>>& grains) {
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    const Run& r = run(chunk, s);
    if (r.first == r.last) continue;
    if (surfaces[s].shape.kind() == ShapeKind::plane)
      plane_geometry(surfaces[s], r, space, grains);
    else
      part_geometry(surfaces[s], r, space, grains);
  }
}

template <class R>
void Bodies<R>::plane_geometry(const Surface& s, const Run& r, const Space<R>& space, const Array<Grain<R>>& grains) {
  const Body& body = bodies[static_cast<std::size_t>(s.body)];
  const Vec3 normal = body.X.q * s.shape.normal(), arm = body.X.q * s.shape.point(),
             from = body.X.p + arm - space.domain().lo;
  double n[3], c = 0;
  for (int k = 0; k < 3; ++k) {
    // Planes are square to the periodic axes: positions there do not enter.
    n[k] = normal[k] * space.unit(k);
    c += normal[k] * from[k];
  }
  for (std::uint32_t at = r.first; at < r.last; ++at) {
    WallBlock<R>& b = blocks_[at];
    for (int l = 0; l < kBlock; ++l) {
      const std::uint32_t place = b.i[l] / kUnit;
      const Grain<R>& g = grains[place];
      double d = -c;
      for (int k = 0; k < 3; ++k) d += n[k] * static_cast<double>(g.p[k]);
      const bool padding = std::size_t{place} + 2 == grains.size();
      b.delta[l] = padding ? R(-1) : static_cast<R>(static_cast<double>(g.r) - d);
      b.curvature[l] = 0;
      for (int k = 0; k < 3; ++k) {
        b.n[k][l] = static_cast<R>(-normal[k]);
        b.v[k][l] = static_cast<R>(body.V.v[k]);
        b.w[k][l] = 0;
        b.at[k][l] = static_cast<R>(arm[k]);
      }
    }
  }
}

template <class R>
void Bodies<R>::part_geometry(const Surface& s, const Run& r, const Space<R>& space, const Array<Grain<R>>& grains) {
  const Body& body = bodies[static_cast<std::size_t>(s.body)];
  const auto lane = [&](std::size_t at) {
    return std::pair<WallBlock<R>&, std::size_t>(blocks_[at / kBlock], at % kBlock);
  };
  const std::size_t end = std::size_t{r.last} * kBlock;
  std::vector<Touch> touch;
  std::vector<R> was;
  std::vector<Vec3> had;
  for (std::size_t at = std::size_t{r.first} * kBlock; at < end;) {
    const std::uint32_t place = lane(at).first.i[lane(at).second] / kUnit;
    std::size_t next = at;
    while (next < end && lane(next).first.i[lane(next).second] / kUnit == place) ++next;
    if (std::size_t{place} + 2 == grains.size()) {
      for (; at < next; ++at) {
        const auto [b, l] = lane(at);
        b.delta[l] = -1;
        b.curvature[l] = 0;
        for (int k = 0; k < 3; ++k) b.n[k][l] = b.v[k][l] = b.w[k][l] = b.at[k][l] = 0;
      }
      continue;
    }
    const Grain<R>& g = grains[place];
    const Vec3 x = local(space, g, body);
    touch.clear();
    was.clear();
    had.clear();
    for (std::size_t k = at; k < next; ++k) {
      const auto [b, l] = lane(k);
      const Touch t = s.shape.touch(b.part[l], x);
      was.push_back(b.delta[l]);
      had.push_back(Vec3(double(b.n[0][l]), double(b.n[1][l]), double(b.n[2][l])));
      touch.push_back(t);
      const double delta = double(g.r) - t.distance;
      const Vec3 normal = body.X.q * t.normal, arm = body.X.q * Vec3(t.point + 0.5 * delta * t.normal),
                 v = body.V.at(arm);
      b.delta[l] = static_cast<R>(delta);
      b.curvature[l] = static_cast<R>(t.curvature);
      for (int c = 0; c < 3; ++c) {
        b.n[c][l] = static_cast<R>(normal[c]);
        b.v[c][l] = static_cast<R>(v[c]);
        b.w[c][l] = static_cast<R>(body.V.w[c]);
        b.at[c][l] = static_cast<R>(arm[c]);
      }
    }
    if (next - at > 1 && s.shape.kind() == ShapeKind::mesh) {
      one_contact_per_place(s, at, next, touch);
      // A contact that goes over from one triangle to its neighbour takes its history along.
      for (std::size_t k = at; k < next; ++k) {
        const auto [b, l] = lane(k);
        if (!(b.delta[l] > 0) || was[k - at] > 0) continue;
        const Vec3 normal(double(b.n[0][l]), double(b.n[1][l]), double(b.n[2][l]));
        for (std::size_t o = at; o < next; ++o) {
          const auto [from, m] = lane(o);
          if (from.delta[m] > 0 || !(was[o - at] > 0) || had[o - at].dot(normal) < 0.9) continue;
          for (int c = 0; c < 3; ++c) {
            b.s[c][l] = from.s[c][m];
            b.t[c][l] = from.t[c][m];
            from.s[c][m] = from.t[c][m] = 0;
          }
          was[o - at] = 0;
          break;
        }
      }
    }
    at = next;
  }
}

/// A point on an edge or a corner belongs to several triangles; the deepest contact of each place stays.
template <class R>
void Bodies<R>::one_contact_per_place(const Surface& s, std::size_t first, std::size_t last,
                                      const std::vector<Touch>& touch) {
  std::vector<std::size_t> order, kept;
  for (std::size_t k = first; k < last; ++k)
    if (blocks_[k / kBlock].delta[k % kBlock] > 0) order.push_back(k);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return touch[a - first].distance < touch[b - first].distance; });
  for (std::size_t k : order) {
    const Vec3& q = touch[k - first].point;
    bool taken = false;
    for (std::size_t o : kept)
      taken = taken || (s.shape.nearest_on(blocks_[o / kBlock].part[o % kBlock], q) - q).squaredNorm() < 1e-16;
    if (taken)
      blocks_[k / kBlock].delta[k % kBlock] = -1;
    else
      kept.push_back(k);
  }
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
      if (b.set.locked[static_cast<std::size_t>(3 + k)]) {
        held.row(k).setZero();
        held.col(k).setZero();
        held(k, k) = 1;
        rest[k] = 0;
      }
    const Vec3 alpha = held.inverse() * rest;
    for (int k = 0; k < 3; ++k) {
      if (!b.set.locked[static_cast<std::size_t>(k)]) b.V.v[k] += a[k] * dt;
      if (!b.set.locked[static_cast<std::size_t>(3 + k)]) b.V.w[k] += alpha[k] * dt;
    }
  }
  b.X.p += b.V.v * dt;
  const double angle = b.V.w.norm() * dt;
  if (angle > 0) b.X.q = (Quat(Eigen::AngleAxisd(angle, Eigen::Vector3d(b.V.w.normalized()))) * b.X.q).normalized();
}

template <class R>
void Bodies<R>::finish(double dt, const Vec3& gravity, std::size_t chunks) {
  for (Body& b : bodies) {
    b.report.force = b.report.torque = Vec3::Zero();
    b.report.contacts = 0;
  }
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    Surface& surface = surfaces[s];
    Body& body = bodies[static_cast<std::size_t>(surface.body)];
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    int contacts = 0;
    for (std::size_t c = 0; c < chunks; ++c)
      for (std::uint32_t at = run(c, s).first; at < run(c, s).last; ++at) {
        const WallBlock<R>& b = blocks_[at];
        for (int l = 0; l < kBlock; ++l) {
          if (!(b.delta[l] > 0)) continue;
          const Vec3 f(double(b.f[0][l]), double(b.f[1][l]), double(b.f[2][l]));
          const Vec3 arm(double(b.at[0][l]), double(b.at[1][l]), double(b.at[2][l]));
          const Vec3 roll(double(b.roll[0][l]), double(b.roll[1][l]), double(b.roll[2][l]));
          force -= f;
          torque -= arm.cross(f) + roll;
          ++contacts;
        }
      }
    surface.report.force = force;
    surface.report.torque = torque;
    surface.report.contacts = contacts;
    surface.report.impulse += force * dt;
    const double work = -(force.dot(body.V.v) + torque.dot(body.V.w)) * dt;
    surface.report.work += work;
    body.report.force += force;
    body.report.torque += torque;
    body.report.contacts += contacts;
    body.report.impulse += force * dt;
    body.report.work += work;
  }
  for (Body& b : bodies) move(b, dt, gravity);
}

template class Bodies<float>;
template class Bodies<double>;

}  // namespace grouser::dem
