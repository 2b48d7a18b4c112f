#pragma once
#include "grouser/vehicle/folder_lock.h"
