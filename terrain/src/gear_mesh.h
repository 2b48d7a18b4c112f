#pragma once
#include "grouser/terrain/mesh_file.h"
