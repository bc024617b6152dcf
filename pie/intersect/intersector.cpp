#include "pie/intersect/intersector.h"
