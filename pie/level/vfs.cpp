#include "pie/level/vfs.h"
