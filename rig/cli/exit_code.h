#pragma once
// The exit codes are shared by all programs: config/exit_code.h.
#include "config/exit_code.h"
