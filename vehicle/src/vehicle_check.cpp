// What must hold of any vehicle, whichever file it came from.
#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdio>

#include "vehicle_reader.h"

namespace grouser::vehicle {

std::string unknown_name(const std::string& what, const std::string& name, const std::vector<std::string>& known) {
  std::string all;
  for (const std::string& k : known) all += (all.empty() ? "" : ", ") + k;
  const auto near = did_you_mean(name, known);
  return "unknown " + what + " '" + name + "'" + (near ? "; did you mean '" + *near + "'? known: " : "; known: ") +
         (all.empty() ? "none" : all);
}

int index_of(const std::string& name, const std::vector<std::string>& names) {
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == name) return static_cast<int>(i);
  return -1;
}

std::vector<std::string> link_names(const VehicleSpec& v) {
  std::vector<std::string> n;
  for (const LinkSpec& l : v.links) n.push_back(l.name);
  return n;
}

std::vector<std::string> joint_names(const VehicleSpec& v) {
  std::vector<std::string> n;
  for (const JointSpec& j : v.joints) n.push_back(j.name);
  return n;
}

namespace {

/// Link 0 becomes the root, so that everybody finds the chassis there.
void put_first(VehicleSpec& v, int root) {
  if (root == 0) return;
  auto renumber = [root](int& i) {
    if (i == root)
      i = 0;
    else if (i >= 0 && i < root)
      ++i;
  };
  const LinkSpec l = v.links[root];
  v.links.erase(v.links.begin() + root);
  v.links.insert(v.links.begin(), l);
  for (JointSpec& j : v.joints) renumber(j.parent), renumber(j.child);
  for (WheelSpec& w : v.wheels) renumber(w.link);
}

void remove_joint(VehicleSpec& v, int gone) {
  v.joints.erase(v.joints.begin() + gone);
  auto renumber = [gone](int& i) {
    if (i > gone) --i;
  };
  for (WheelSpec& w : v.wheels) renumber(w.joint);
  for (SteerSpec& s : v.steering) renumber(s.joint);
  if (v.differential) renumber(v.differential->joint_a), renumber(v.differential->joint_b);
}

void remove_link(VehicleSpec& v, int gone) {
  v.links.erase(v.links.begin() + gone);
  auto renumber = [gone](int& i) {
    if (i > gone) --i;
  };
  for (JointSpec& j : v.joints) renumber(j.parent), renumber(j.child);
  for (WheelSpec& w : v.wheels) renumber(w.link);
}

}  // namespace

void check_and_merge(ReadVehicle& r, InputLog& log) {
  VehicleSpec& v = r.spec;
  const std::size_t before = log.errors.size();
  auto at = [&](const Place& p, const std::string& m) { log.error(p.file, p.line, p.column, m); };
  if (v.links.empty()) {
    log.error(v.file, 1, 1, "the vehicle has no body; a vehicle file has them in 'bodies:', a URDF as <link>");
    return;
  }

  // A tree: one parent each, one root, no loop.
  std::vector<int> parent_joint(v.links.size(), -1);
  for (std::size_t j = 0; j < v.joints.size(); ++j) {
    int& p = parent_joint[v.joints[j].child];
    if (v.joints[j].child == v.joints[j].parent)
      at(r.joint_place[j],
         "joint '" + v.joints[j].name + "' joins body '" + v.links[v.joints[j].child].name + "' to itself");
    else if (p >= 0)
      at(r.joint_place[j], "body '" + v.links[v.joints[j].child].name + "' has two parents: joints '" +
                               v.joints[p].name + "' and '" + v.joints[j].name +
                               "'; loops are not supported, each body but the chassis is the child of one joint");
    else
      p = static_cast<int>(j);
  }
  if (log.errors.size() != before) return;
  std::vector<int> roots;
  for (std::size_t i = 0; i < v.links.size(); ++i)
    if (parent_joint[i] < 0) roots.push_back(static_cast<int>(i));
  for (std::size_t i = 1; i < roots.size(); ++i)
    at(r.link_place[roots[i]], "body '" + v.links[roots[i]].name + "' is not joined to '" + v.links[roots[0]].name +
                                   "': one body (the chassis) has no parent, every other one is the child of a joint");
  for (std::size_t i = 0; i < v.links.size(); ++i) {
    int at_link = static_cast<int>(i);
    std::size_t hops = 0;
    while (parent_joint[at_link] >= 0 && hops++ <= v.links.size()) at_link = v.joints[parent_joint[at_link]].parent;
    if (hops > v.links.size()) {
      at(r.joint_place[parent_joint[i]],
         "joint '" + v.joints[parent_joint[i]].name + "' closes a loop; loops are not supported");
      break;
    }
  }
  if (log.errors.size() != before) return;

  // Fixed joints: child into parent, leaves first by repeating until none is left.
  std::vector<Place> link_place = r.link_place;
  const int root = roots[0];
  std::rotate(link_place.begin(), link_place.begin() + root, link_place.begin() + root + 1);
  put_first(v, root);
  for (int j = static_cast<int>(v.joints.size()) - 1; j >= 0; --j) {
    if (!r.fixed[j]) continue;
    const int p = v.joints[j].parent, c = v.joints[j].child;
    if (v.links[p].mass + v.links[c].mass > 0) {
      merge_fixed(v.links[p], v.links[c]);
    } else {
      for (Visual s : v.links[c].visuals) {
        s.X_BS = v.links[p].X_VB.inverse() * (v.links[c].X_VB * s.X_BS);
        v.links[p].visuals.push_back(s);
      }
    }
    for (JointSpec& other : v.joints)
      if (other.parent == c) other.parent = p;
    for (WheelSpec& w : v.wheels)
      if (w.link == c) w.link = p;
    remove_joint(v, j);
    remove_link(v, c);
    link_place.erase(link_place.begin() + c);
  }

  for (std::size_t i = 0; i < v.links.size(); ++i) {
    const LinkSpec& l = v.links[i];
    if (!(l.mass > 0)) {
      at(link_place[i],
         "body '" + l.name +
             "' has no mass: every body that is not fixed to another needs a positive mass and an inertia");
      continue;
    }
    const Eigen::Vector3d e = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(Eigen::Matrix3d(l.inertia)).eigenvalues();
    if (!(e(0) > 0) || e(2) > (e(0) + e(1)) * (1 + 1e-9)) {
      char text[256];
      std::snprintf(
          text, sizeof text,
          "inertia of body '%s' belongs to no body: principal moments %.6g, %.6g, %.6g kg m^2 must be positive and the "
          "largest at most the sum of the others",
          l.name.c_str(), e(0), e(1), e(2));
      at(link_place[i], text);
    }
  }
  if (v.wheels.empty() && !r.wheels_elsewhere)
    log.error(v.file, 1, 1, "the vehicle has no wheel; give at least one in 'wheels:'");
}

}  // namespace grouser::vehicle
