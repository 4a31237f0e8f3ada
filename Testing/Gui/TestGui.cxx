// SPDX-License-Identifier: BSD-3-Clause
// Runs the tests of the widgets in one QApplication, on Qt's platform without a display.
#include <gtest/gtest.h>

#include <QApplication>

int main(int argc, char** argv)
{
  testing::InitGoogleTest(&argc, argv);
  qputenv("QT_QPA_PLATFORM", "offscreen");
  QApplication application(argc, argv);
  return RUN_ALL_TESTS();
}
