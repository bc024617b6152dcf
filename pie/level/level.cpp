#include "pie/level/level.h"
