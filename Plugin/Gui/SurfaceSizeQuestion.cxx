// SPDX-License-Identifier: BSD-3-Clause
#include "SurfaceSizeQuestion.h"

#include "CountWords.h"

#include "pqCoreUtilities.h"

#include <QMessageBox>
#include <QPushButton>

namespace isosurface
{

QDialog* AskAboutSurfaceSize(const QString& title, const Refinement& report,
  const std::function<void()>& useFittingLevel, const std::function<void()>& extractAnyway)
{
  auto* box = new QMessageBox(pqCoreUtilities::mainWidget());
  box->setObjectName("SurfaceSizeDialog");
  box->setAttribute(Qt::WA_DeleteOnClose);
  box->setWindowTitle(title);
  box->setText(QMessageBox::tr("The surface at level %1 has about %2 triangles. They need about %3 "
                               "of memory, and %4 are free.")
                 .arg(report.NextLevel)
                 .arg(FormatCount(report.Triangles))
                 .arg(FormatBytes(report.Bytes))
                 .arg(FormatBytes(report.FreeBytes)));
  QPushButton* fitting = box->addButton(
    QMessageBox::tr("Use Level %1").arg(report.FittingLevel), QMessageBox::AcceptRole);
  QPushButton* anyway =
    box->addButton(QMessageBox::tr("Extract Anyway"), QMessageBox::DestructiveRole);
  box->addButton(QMessageBox::tr("Keep Level %1").arg(report.ShownLevel), QMessageBox::RejectRole);
  fitting->setObjectName("UseLevel");
  anyway->setObjectName("ExtractAnyway");
  box->setDefaultButton(fitting);
  QObject::connect(fitting, &QPushButton::clicked, box, useFittingLevel);
  QObject::connect(anyway, &QPushButton::clicked, box, extractAnyway);
  // Not exec: the window goes on.
  box->setModal(false);
  box->show();
  return box;
}

} // namespace isosurface
