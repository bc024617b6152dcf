#include "pie/lights/import.h"
