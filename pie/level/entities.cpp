#include "pie/level/entities.h"
