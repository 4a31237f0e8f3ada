// SPDX-License-Identifier: BSD-3-Clause
#include "pqVolumeOpeningBehavior.h"

#include "WindowCall.h"

#include "pqActiveObjects.h"
#include "pqCoreUtilities.h"
#include "pqFileDialog.h"
#include "pqLoadDataReaction.h"
#include "pqServer.h"
#include "vtkSMProxyManager.h"
#include "vtkSMReaderFactory.h"

#include <QAction>
#include <QCoreApplication>
#include <QEvent>
#include <QLabel>
#include <QListWidget>
#include <QMenu>
#include <QTimer>

namespace
{

constexpr const char* Group = "sources";
constexpr const char* AnySizeReader = "AnySizeVolumeReader";

bool IsOurs(const QString& reader)
{
  return reader == AnySizeReader || reader == "BlockedVolumeReader" || reader == "EdgeIndexReader";
}

/// The file of the question: of those that were chosen, the one in its text, which may be translated.
QString FindFile(const QDialog* question)
{
  QString found;
  const auto* label = question->findChild<QLabel*>("FileInfo");
  const auto* chooser = pqCoreUtilities::mainWidget()->findChild<pqFileDialog*>("FileOpenDialog");
  if (label && chooser)
  {
    for (const QStringList& files : const_cast<pqFileDialog*>(chooser)->getAllSelectedFiles())
    {
      const QString file = files.value(0);
      found = file.size() > found.size() && label->text().contains(file) ? file : found;
    }
  }
  return found;
}

} // namespace

void pqVolumeOpeningBehavior::OnStartup()
{
  isosurface::CallWithWindow(this, &pqVolumeOpeningBehavior::AddToMenu);
  QCoreApplication::instance()->installEventFilter(this);
}

void pqVolumeOpeningBehavior::OnShutdown()
{
  QCoreApplication::instance()->removeEventFilter(this);
}

void pqVolumeOpeningBehavior::AddToMenu()
{
  const QWidget* window = pqCoreUtilities::mainWidget();
  auto* menu = window ? window->findChild<QMenu*>("menu_File") : nullptr;
  if (menu)
  {
    auto* action = new QAction(tr("Open Volume Folder..."), menu);
    action->setObjectName("actionOpenVolumeFolder");
    action->setToolTip(tr("Opens a folder with a DICOM series, a TIFF stack, Zarr or N5."));
    QObject::connect(action, &QAction::triggered, this, &pqVolumeOpeningBehavior::OpenFolder);
    const QList<QAction*> entries = menu->actions();
    const auto open = entries.indexOf(window->findChild<QAction*>("actionFileOpen"));
    menu->insertAction(entries.value(open + 1), action);
  }
}

void pqVolumeOpeningBehavior::OpenFolder()
{
  pqServer* server = pqActiveObjects::instance().activeServer();
  if (!server)
  {
    return;
  }
  pqFileDialog dialog(server, pqCoreUtilities::mainWidget(), tr("Open Volume Folder"), QString(),
    tr("Folders of DICOM, TIFF, Zarr or N5") + " (*)");
  dialog.setObjectName("VolumeFolderDialog");
  dialog.setFileMode(pqFileDialog::Directory);
  if (dialog.exec() == QDialog::Accepted)
  {
    pqLoadDataReaction::loadData(dialog.getSelectedFiles(), Group, AnySizeReader, server);
  }
}

bool pqVolumeOpeningBehavior::eventFilter(QObject* object, QEvent* event)
{
  if (event->type() == QEvent::Show && object->objectName() == "pqSelectReaderDialog")
  {
    if (const auto* question = qobject_cast<QDialog*>(object))
    {
      this->Propose(question);
    }
  }
  return QObject::eventFilter(object, event);
}

void pqVolumeOpeningBehavior::Propose(const QDialog* question) const
{
  auto* readers = question->findChild<QListWidget*>("listWidget");
  const pqServer* server = pqActiveObjects::instance().activeServer();
  const QString file = FindFile(question);
  vtkSMReaderFactory* factory = vtkSMProxyManager::GetProxyManager()->GetReaderFactory();
  if (!readers || !server || file.isEmpty() ||
    !factory->CanReadFile(file.toUtf8().data(), server->session()) ||
    !IsOurs(factory->GetReaderName()))
  {
    return;
  }
  for (int row = 0; row < readers->count(); ++row)
  {
    QListWidgetItem* item = readers->item(row);
    if (item->data(Qt::UserRole + 1).toString() == factory->GetReaderName())
    {
      readers->setCurrentItem(item, QItemSelectionModel::ClearAndSelect);
      QTimer::singleShot(0, readers, [readers, item] { readers->scrollToItem(item); });
    }
  }
}
