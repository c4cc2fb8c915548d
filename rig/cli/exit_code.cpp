#include "rig/cli/exit_code.h"  // the floor needs one source until its commands land
