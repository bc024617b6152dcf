#include "pie/level/bsp.h"
