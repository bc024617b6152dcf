#include "pie/level/patch.h"
