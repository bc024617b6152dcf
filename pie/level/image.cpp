#include "pie/level/image.h"
