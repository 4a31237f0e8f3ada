// SPDX-License-Identifier: BSD-3-Clause
// Gives the player of ParaView's window two commands, so that scripts wait for what they need:
//
//   waitUntil   PROPERTY=VALUE: handles events until the object's property has had this value for a while
//   wait        MILLISECONDS: handles events for so long; in a pause of the player, timers time out once
//
// The tests preload this library into the window: the plugin itself has no part that only tests use.
#include <pqApplicationCore.h>
#include <pqEventPlayer.h>
#include <pqTestUtility.h>
#include <pqWidgetEventPlayer.h>

#include <QCoreApplication>
#include <QElapsedTimer>
#include <QPointer>
#include <QThread>
#include <QTimer>
#include <QVariant>
#include <QtDebug>

constexpr qint64 LongestWait = 120000; // milliseconds, on a machine that others use as well
constexpr qint64 Calm =
  300; // a value that has been there before the last event took effect goes meanwhile

static void HandleEvents()
{
  QCoreApplication::processEvents(QEventLoop::AllEvents, 20);
  QThread::msleep(5);
}

/// The list of players has one of each class by its name.
class WaitingPlayer : public pqWidgetEventPlayer
{
  Q_OBJECT

public:
  using pqWidgetEventPlayer::playEvent;
  using pqWidgetEventPlayer::pqWidgetEventPlayer;

  bool playEvent(
    QObject* object, const QString& command, const QString& arguments, bool& error) override
  {
    if (command == "wait")
    {
      QElapsedTimer waiting;
      waiting.start();
      while (waiting.elapsed() < arguments.toLongLong())
      {
        HandleEvents();
      }
      return true;
    }
    if (command != "waitUntil")
    {
      return false;
    }
    error = !WaitUntil(object, arguments.section('=', 0, 0), arguments.section('=', 1));
    return true;
  }

private:
  static bool WaitUntil(
    const QPointer<QObject>& object, const QString& property, const QString& wanted)
  {
    QElapsedTimer waiting;
    waiting.start();
    QElapsedTimer held;
    QString value;
    while (object && waiting.elapsed() < LongestWait)
    {
      value = object->property(property.toUtf8().constData()).toString();
      if (value != wanted)
      {
        held.invalidate();
      }
      else if (!held.isValid())
      {
        held.start();
      }
      else if (held.elapsed() >= Calm)
      {
        return true;
      }
      HandleEvents();
    }
    qCritical() << "waitUntil:" << property << "is" << value << "in place of" << wanted;
    return false;
  }
};

/// Adds the player as soon as the window's core is there.
static void AddPlayer()
{
  pqApplicationCore* core = pqApplicationCore::instance();
  if (!core || !core->testUtility())
  {
    QTimer::singleShot(10, &AddPlayer);
    return;
  }
  core->testUtility()->eventPlayer()->addWidgetEventPlayer(
    new WaitingPlayer(core->testUtility()->eventPlayer()));
}

/// Programs that the window starts, as MPI's daemon, do without.
static const bool IsPreloadedHereAlone = qunsetenv("LD_PRELOAD");

Q_COREAPP_STARTUP_FUNCTION(AddPlayer)

#include "WaitUntil.moc"
