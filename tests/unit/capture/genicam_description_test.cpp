#include "capture/source/genicam_description.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "simulator/gige/genicam_xml.h"

namespace rotunda::capture {
namespace {

using testing::HasSubstr;

std::string description(const std::string& nodes) {
  return "<?xml version=\"1.0\"?><RegisterDescription ModelName=\"M\" VendorName=\"V\">" + nodes +
         "</RegisterDescription>";
}

std::string problem_of(const std::string& nodes) {
  return description_problem(description(nodes));
}

std::string repeated(int times, const std::function<std::string(int)>& each) {
  std::string all;
  for (int i = 0; i < times; ++i) all += each(i);
  return all;
}

std::string chain_of(int nodes) {
  return repeated(nodes,
                  [](int i) { return fmt::format("<Integer Name=\"N{}\"><pValue>N{}</pValue></Integer>", i, i + 1); });
}

TEST(GenicamDescription, OfTheSimulatedCamerasAndOfNodesThatLimitEachOtherMayBeEvaluated) {
  EXPECT_EQ(description_problem(simulator::genicam_xml({})), "");
  EXPECT_EQ(problem_of("<Integer Name=\"Width\"><pValue>WidthReg</pValue><pMax>WidthMax</pMax></Integer>"
                       "<Integer Name=\"OffsetX\"><pValue>OffsetReg</pValue><pMax>OffsetMax</pMax></Integer>"
                       "<IntSwissKnife Name=\"WidthMax\"><pVariable Name=\"X\">OffsetX</pVariable>"
                       "<Formula>720 - X</Formula></IntSwissKnife>"
                       "<IntSwissKnife Name=\"OffsetMax\"><pVariable Name=\"X\">Width</pVariable>"
                       "<Formula>720 - X</Formula></IntSwissKnife>"
                       "<IntReg Name=\"WidthReg\"><Address>0x10</Address></IntReg>"
                       "<IntReg Name=\"OffsetReg\"><Address>0x14</Address></IntReg>"),
            "");
}

TEST(GenicamDescription, WhoseValuesNeedThemselvesIsToldByNode) {
  EXPECT_THAT(problem_of("<Integer Name=\"Width\"><pValue> Width </pValue></Integer>"), HasSubstr("\"Width\""));
  EXPECT_THAT(problem_of("<Group><Integer Name=\"A\"><pValue>B</pValue></Integer></Group>"
                         "<IntReg Name=\"B\"><pAddress>C</pAddress></IntReg>"
                         "<IntSwissKnife Name=\"C\"><Constant Name=\"TWO\">2</Constant>"
                         "<pVariable Name=\"X\"><![CDATA[A]]></pVariable></IntSwissKnife>"),
              HasSubstr("needs itself"));
  EXPECT_THAT(problem_of("<Integer Name=\"A\"><Odd Name=\"B\"><pValue>A</pValue></Odd></Integer>"),
              HasSubstr("needs itself"))
      << "whatever stands between";
  EXPECT_THAT(problem_of("<Integer Name=\"A\"><Value>1</Value></Integer>"
                         "<Integer Name=\"A\"><pValue>A</pValue></Integer>"),
              HasSubstr("needs itself"))
      << "of two of a name either may count";
}

TEST(GenicamDescription, ThatTakesForEverOrTooMuchIsRefused) {
  EXPECT_EQ(problem_of(chain_of(150)), "");
  EXPECT_THAT(problem_of(chain_of(250)), HasSubstr("in a row"));
  EXPECT_THAT(problem_of(chain_of(100'000)), HasSubstr("in a row")) << "without running out of stack";
  const auto doubling = repeated(30, [](int i) {
    return fmt::format(
        "<IntSwissKnife Name=\"N{}\"><pVariable Name=\"A\">N{}</pVariable>"
        "<pVariable Name=\"B\">N{}</pVariable></IntSwissKnife>",
        i, i + 1, i + 1);
  });
  EXPECT_THAT(problem_of(doubling), HasSubstr("steps"));
  EXPECT_THAT(problem_of(repeated(300'000, [](int i) { return fmt::format("<Float Name=\"N{}\">1</Float>", i); })),
              HasSubstr("nodes"));
  EXPECT_THAT(problem_of(repeated(1000, [](int) { return std::string("<Group>"); })), HasSubstr("deep"));
  EXPECT_THAT(description_problem(std::string(20 << 20, ' ')), HasSubstr("bytes"));
  EXPECT_THAT(description_problem("<!DOCTYPE a [<!ENTITY b \"c\">]><a>&b;</a>"), HasSubstr("entities"));
}

TEST(GenicamDescription, CutAnywhereIsNoWholeXml) {
  const auto whole = description(chain_of(3));
  for (std::size_t bytes = 0; bytes < whole.size(); ++bytes)
    EXPECT_THAT(description_problem(whole.substr(0, bytes)), HasSubstr("no")) << bytes;
  EXPECT_EQ(description_problem(whole), "");
}

TEST(GenicamDescription, IsFetchedFromTheCameraOnlyAndOnlyIfItCanBe) {
  EXPECT_EQ(url_problem("Local:rotunda.xml;8000;2f3c"), "");
  EXPECT_EQ(url_problem("local:a.zip;FFFF0000;1000?SchemaVersion=1.1.0"), "");
  EXPECT_EQ(url_problem("Local:a.xml;0x8000;0x1000"), "");
  EXPECT_EQ(url_problem(""), "");
  for (const char* url : {"File:///dev/zero", "file:/etc/passwd", "http://example.org/a.xml", "https://a/b", "/a.xml"})
    EXPECT_THAT(url_problem(url), HasSubstr("elsewhere")) << url;
  for (const char* url : {"Local:", "Local:a.xml", "Local:a.xml;8000", "Local:a.xml;8000;", "Local:a.xml;8000;z"})
    EXPECT_THAT(url_problem(url), HasSubstr("no place")) << url;
  EXPECT_THAT(url_problem("Local:a.xml;8000;ffffffff"), HasSubstr("4294967295 bytes"));
  EXPECT_EQ(url_problem("Local:a.xml;8000;200000"), "");
  EXPECT_THAT(url_problem("Local:a.ZIP;8000;200000"), HasSubstr("2097152 bytes"))
      << "zipped it may be a thousand times that";
  EXPECT_THAT(url_problem("Local:a.xml;8000;ffffffffffffffffffff"), HasSubstr("no place"));
}

}  // namespace
}  // namespace rotunda::capture
