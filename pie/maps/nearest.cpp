#include "pie/maps/nearest.h"
