// SPDX-License-Identifier: BSD-3-Clause
#include "pqIsovalueChart.h"

#include <gtest/gtest.h>

#include <QApplication>
#include <QImage>
#include <QKeyEvent>
#include <QSignalSpy>
#include <QWheelEvent>
#include <QtTest>

#include <cmath>
#include <cstdlib>

namespace
{

constexpr int Width = 300;
constexpr int Height = 150;

/// A chart of 0 ... 200 whose spectrum is a tent of 1,000,000 triangles at 100.
class IsovalueChart : public testing::Test
{
protected:
  void SetUp() override
  {
    this->Chart.resize(Width, Height);
    this->Chart.SetSpectrum(MakeTent(true));
    this->Chart.SetIsovalues({ 50.0, 120.0 });
    this->Chart.show();
    QApplication::processEvents();
  }

  static isosurface::SpectrumCurve MakeTent(bool integers)
  {
    std::vector<double> isovalues;
    isosurface::SpectrumCurve::Columns columns;
    for (int value = 0; value <= 200; ++value)
    {
      const double triangles = (100 - std::abs(value - 100)) * 1e4;
      isovalues.push_back(value);
      columns[0].push_back(triangles);
      columns[2].push_back(triangles / 1e3);
      columns[3].push_back(triangles * 10);
      columns[4].push_back(triangles / 2);
      columns[5].push_back(200 - value);
    }
    return isosurface::SpectrumCurve(isovalues, columns, integers);
  }

  QPoint At(double isovalue) const
  {
    return QPoint(static_cast<int>(std::lround(this->Chart.GetAxis().ToPixel(isovalue))), 60);
  }

  void MoveMouse(const QPoint& place, Qt::MouseButtons buttons)
  {
    QMouseEvent move(QEvent::MouseMove, place, this->Chart.mapToGlobal(place), Qt::NoButton,
      buttons, Qt::NoModifier);
    QApplication::sendEvent(&this->Chart, &move);
  }

  void Drag(double from, double to)
  {
    QTest::mousePress(&this->Chart, Qt::LeftButton, Qt::NoModifier, At(from));
    this->MoveMouse(At(to), Qt::LeftButton);
    QTest::mouseRelease(&this->Chart, Qt::LeftButton, Qt::NoModifier, At(to));
  }

  void Roll(int delta, const QPoint& place, Qt::KeyboardModifiers modifiers = Qt::NoModifier)
  {
    QWheelEvent wheel(place, this->Chart.mapToGlobal(place), QPoint(), QPoint(0, delta),
      Qt::NoButton, modifiers, Qt::NoScrollPhase, false);
    QApplication::sendEvent(&this->Chart, &wheel);
  }

  double GetIsovalue(int handle) const { return this->Chart.GetIsovalues()[handle].toDouble(); }

  /// Pixels of about a colour in a row of the drawn chart.
  int CountPixels(const QColor& color, int row)
  {
    const QImage image = this->Chart.grab().toImage();
    int count = 0;
    for (int x = 0; x < image.width(); ++x)
    {
      const QColor pixel = image.pixelColor(x, row);
      count += std::abs(pixel.red() - color.red()) + std::abs(pixel.green() - color.green()) +
          std::abs(pixel.blue() - color.blue()) <
        60;
    }
    return count;
  }

  pqIsovalueChart Chart;
};

TEST_F(IsovalueChart, DragMovesAHandleToAWholeNumber)
{
  this->Drag(50, 80.3);
  EXPECT_NEAR(this->GetIsovalue(0), 80, 1);
  EXPECT_EQ(this->GetIsovalue(0), std::round(this->GetIsovalue(0)));
  EXPECT_EQ(this->GetIsovalue(1), 120);
}

TEST_F(IsovalueChart, DragOfRealsStopsBetweenWholeNumbers)
{
  this->Chart.SetSpectrum(MakeTent(false));
  this->Drag(50, 81);
  EXPECT_NEAR(this->GetIsovalue(0), 81, 0.7);
  EXPECT_NE(this->GetIsovalue(0), std::round(this->GetIsovalue(0)));
}

TEST_F(IsovalueChart, DragTellsItsBeginEveryMoveAndItsEnd)
{
  QSignalSpy started(&this->Chart, &pqIsovalueChart::dragStarted);
  QSignalSpy changed(&this->Chart, &pqIsovalueChart::isovaluesChanged);
  QSignalSpy finished(&this->Chart, &pqIsovalueChart::dragFinished);
  QTest::mousePress(&this->Chart, Qt::LeftButton, Qt::NoModifier, At(50));
  EXPECT_EQ(started.size(), 1);
  EXPECT_TRUE(this->Chart.IsDragging());
  this->MoveMouse(At(60), Qt::LeftButton);
  this->MoveMouse(At(70), Qt::LeftButton);
  EXPECT_EQ(changed.size(), 2);
  EXPECT_EQ(finished.size(), 0);
  QTest::mouseRelease(&this->Chart, Qt::LeftButton, Qt::NoModifier, At(70));
  EXPECT_EQ(finished.size(), 1);
}

TEST_F(IsovalueChart, DragEndsWhereTheReleaseWasSwallowed)
{
  QSignalSpy finished(&this->Chart, &pqIsovalueChart::dragFinished);
  QTest::mousePress(&this->Chart, Qt::LeftButton, Qt::NoModifier, At(50));
  this->MoveMouse(At(60), Qt::LeftButton);
  const double before = this->GetIsovalue(0);
  this->MoveMouse(At(90), Qt::NoButton);
  EXPECT_EQ(finished.size(), 1);
  EXPECT_EQ(this->GetIsovalue(0), before);
}

TEST_F(IsovalueChart, AClickMovesNothing)
{
  QSignalSpy changed(&this->Chart, &pqIsovalueChart::isovaluesChanged);
  QTest::mouseClick(&this->Chart, Qt::LeftButton, Qt::NoModifier, At(50) + QPoint(3, 0));
  EXPECT_EQ(changed.size(), 0);
  EXPECT_EQ(this->Chart.GetSelected(), 0);
}

TEST_F(IsovalueChart, DoubleClickAddsAHandleAtTheEndOfTheList)
{
  QTest::mouseDClick(&this->Chart, Qt::LeftButton, Qt::NoModifier, At(160));
  ASSERT_EQ(this->Chart.GetIsovalues().size(), 3);
  EXPECT_NEAR(this->GetIsovalue(2), 160, 1);
  EXPECT_EQ(this->GetIsovalue(0), 50);
  EXPECT_EQ(this->Chart.GetSelected(), 2);
}

TEST_F(IsovalueChart, DoubleClickOnAHandleAddsNone)
{
  QTest::mouseDClick(&this->Chart, Qt::LeftButton, Qt::NoModifier, At(50));
  EXPECT_EQ(this->Chart.GetIsovalues().size(), 2);
}

TEST_F(IsovalueChart, DeleteRemovesTheSelectedHandle)
{
  QTest::mouseClick(&this->Chart, Qt::LeftButton, Qt::NoModifier, At(50));
  QTest::keyClick(&this->Chart, Qt::Key_Delete);
  EXPECT_EQ(this->Chart.GetIsovalueText(), "120");
  QTest::keyClick(&this->Chart, Qt::Key_Delete);
  QTest::keyClick(&this->Chart, Qt::Key_Delete);
  EXPECT_EQ(this->Chart.GetIsovalueText(), "");
}

TEST_F(IsovalueChart, DeleteIsNotTheWindowsWhileAHandleIsSelected)
{
  const auto isTaken = [this]
  {
    QKeyEvent shortcut(QEvent::ShortcutOverride, Qt::Key_Delete, Qt::NoModifier);
    shortcut.ignore();
    QApplication::sendEvent(&this->Chart, &shortcut);
    return shortcut.isAccepted();
  };
  this->Chart.Select(-1);
  EXPECT_FALSE(isTaken());
  this->Chart.Select(0);
  EXPECT_TRUE(isTaken());
}

TEST_F(IsovalueChart, ArrowKeysMoveByFineSteps)
{
  this->Chart.Select(1);
  QTest::keyClick(&this->Chart, Qt::Key_Right);
  EXPECT_EQ(this->GetIsovalue(1), 121);
  QTest::keyClick(&this->Chart, Qt::Key_Left, Qt::ShiftModifier);
  EXPECT_EQ(this->GetIsovalue(1), 111);
  QTest::keyClick(&this->Chart, Qt::Key_PageDown);
  EXPECT_EQ(this->Chart.GetSelected(), 0);
}

TEST_F(IsovalueChart, WheelZoomsAroundTheMouseAndHomeShowsAll)
{
  const QPoint place = At(100);
  this->Roll(120 * 5, place);
  EXPECT_TRUE(this->Chart.IsZoomed());
  EXPECT_NEAR(this->Chart.GetAxis().ToValue(place.x()), 100, 0.5);
  const double narrow = this->Chart.GetAxis().GetMaximum() - this->Chart.GetAxis().GetMinimum();
  EXPECT_NEAR(narrow, 200 / std::pow(1.25, 5), 1e-6);
  const double before = this->Chart.GetAxis().GetMinimum();
  this->Roll(-120, place, Qt::ShiftModifier);
  EXPECT_GT(this->Chart.GetAxis().GetMinimum(), before);
  QTest::keyClick(&this->Chart, Qt::Key_Home);
  EXPECT_FALSE(this->Chart.IsZoomed());
}

TEST_F(IsovalueChart, ReadsWhatTheSurfaceWillCostWhileItIsDragged)
{
  this->Chart.SetStored(true);
  this->Chart.SetDurationWords([](const isosurface::IsosurfaceForecast& forecast)
    { return QString("about %1 s").arg(forecast.Triangles / 1e6); });
  QTest::mousePress(&this->Chart, Qt::LeftButton, Qt::NoModifier, At(50));
  this->MoveMouse(At(100), Qt::LeftButton);
  EXPECT_EQ(this->GetIsovalue(0), 100);
  EXPECT_EQ(
    this->Chart.GetReadout(), "100; 1.00 M triangles; 1.00 k blocks, 9.54 MiB to read; about 1 s");
}

TEST_F(IsovalueChart, ReadsWhatASurfaceWouldCostUnderTheMouse)
{
  this->MoveMouse(At(150), Qt::NoButton);
  EXPECT_TRUE(this->Chart.GetReadout().contains("triangles"))
    << this->Chart.GetReadout().toStdString();
  QEvent leave(QEvent::Leave);
  QApplication::sendEvent(&this->Chart, &leave);
  EXPECT_EQ(this->Chart.GetReadout(), "");
}

TEST_F(IsovalueChart, HandlesHaveTheColorsOfTheirSurfaces)
{
  this->Chart.SetColors({ Qt::red, Qt::green });
  EXPECT_GE(this->CountPixels(Qt::red, 3), 4);
  EXPECT_GE(this->CountPixels(Qt::green, 3), 4);
  EXPECT_EQ(this->CountPixels(Qt::blue, 3), 0);
}

TEST_F(IsovalueChart, AHandleOutOfSightLeavesItsGripAtTheSide)
{
  this->Chart.SetColors({ Qt::red, Qt::green });
  this->Roll(120 * 10, At(190));
  EXPECT_EQ(this->Chart.FindHandle(QPoint(150, 60)), -1);
  EXPECT_GE(this->CountPixels(Qt::red, 6) + this->CountPixels(Qt::green, 6), 3);
}

TEST_F(IsovalueChart, ValuesFromOutsideAreShownAndNotSentBack)
{
  QSignalSpy changed(&this->Chart, &pqIsovalueChart::isovaluesChanged);
  this->Chart.SetIsovalues({ 10.5 });
  EXPECT_EQ(changed.size(), 0);
  EXPECT_EQ(this->Chart.GetIsovalueText(), "10.5");
}

TEST_F(IsovalueChart, WithoutASpectrumHandlesMoveOverTheRange)
{
  this->Chart.SetSpectrum(isosurface::SpectrumCurve());
  this->Chart.SetRange(-1, 1);
  this->Chart.SetIsovalues({ 0.0 });
  this->Chart.SetMessage("No spectrum");
  this->Drag(0, 0.5);
  EXPECT_NEAR(this->GetIsovalue(0), 0.5, 0.01);
}

TEST_F(IsovalueChart, TellsOfWhichShareOfTheVolumeItIs)
{
  EXPECT_EQ(this->Chart.GetNote(), "");
  const QImage before = this->Chart.grab().toImage();
  this->Chart.SetShare(0.113);
  EXPECT_EQ(this->Chart.GetNote(), "of 12 % of the volume");
  EXPECT_NE(this->Chart.grab().toImage(), before);
  this->Chart.SetSpectrum(isosurface::SpectrumCurve());
  EXPECT_EQ(this->Chart.GetNote(), "") << "there is nothing";
}

TEST_F(IsovalueChart, LogarithmicScaleShowsSmallSurfaces)
{
  // 1 triangle beside 1e6: on a linear scale it is less than a pixel above the bottom.
  isosurface::SpectrumCurve::Columns columns;
  columns[0] = { 1, 1, 1, 1e6, 1e6 };
  this->Chart.SetIsovalues({});
  this->Chart.SetSpectrum(isosurface::SpectrumCurve({ 0, 1, 2, 3, 4 }, columns, false));
  const QImage image = this->Chart.grab().toImage();
  const QColor ground = this->Chart.palette().base().color();
  const int x = static_cast<int>(this->Chart.GetAxis().ToPixel(1));
  int drawn = 0;
  for (int y = 20; y < Height - this->Chart.fontMetrics().height() - 6; ++y)
  {
    drawn += image.pixelColor(x, y) != ground;
  }
  EXPECT_GE(drawn, 3);
}

} // namespace
