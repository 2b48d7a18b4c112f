#pragma once
// Beds as `id,x_m,y_m,z_m,radius_m,vx,..` in a csv, gzipped or not.
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "grouser/dem/solver.h"

inline std::vector<grouser::dem::GrainState> read_bed(const std::string& path, double lx, double ly, int tile_x,
                                                      int tile_y) {
  const std::string command = "gzip -cdf '" + path + "'";
  std::FILE* f = popen(command.c_str(), "r");
  if (!f) throw std::runtime_error("cannot read " + path);
  std::vector<grouser::dem::GrainState> one, all;
  char line[512];
  while (std::fgets(line, sizeof line, f)) {
    double id, x, y, z, r;
    if (std::sscanf(line, "%lf,%lf,%lf,%lf,%lf", &id, &x, &y, &z, &r) != 5) continue;
    grouser::dem::GrainState g;
    g.x = grouser::Vec3(x, y, z);
    g.radius = r;
    g.density = 3100;
    one.push_back(g);
  }
  pclose(f);
  if (one.empty()) throw std::runtime_error("no grains in " + path);
  for (int a = 0; a < tile_x; ++a)
    for (int b = 0; b < tile_y; ++b)
      for (const auto& g : one) {
        all.push_back(g);
        all.back().x += grouser::Vec3(a * lx, b * ly, 0);
      }
  return all;
}
