#include "grouser/models.h"
