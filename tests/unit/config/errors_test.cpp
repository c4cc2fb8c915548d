#include "config/errors.h"

#include <gtest/gtest.h>

namespace rotunda {

TEST(ConfigError, TellsEveryProblemWithItsPlace) {
  const ConfigError error("rig.yaml", {{12, 5, "cameras[3].exposure_us", "expected a number"}, {0, 0, "", "is empty"}});
  EXPECT_STREQ(error.what(), "rig.yaml:12:5: cameras[3].exposure_us: expected a number\nrig.yaml: is empty");
  EXPECT_EQ(error.problems().size(), 2U);
}

}  // namespace rotunda
