# SPDX-License-Identifier: BSD-3-Clause
"""The XML of the plugin in C++, made that of this one."""

import copy
import os
from xml.etree import ElementTree

from ._arrays import VTK_VERSION

#: What stock ParaView has of the widgets, decorators and domains that the window of the plugin in C++ has.
STOCK_WIDGETS = {
    "InteractiveHandle": "InteractiveHandle",
    "region_box": "InteractiveBox",
    "slice_plane": "InteractivePlane",
}
STOCK_DECORATORS = ("GenericDecorator", "CompositeDecorator")
STOCK_DOMAINS = {"IsovalueDomain": "ArrayRangeDomain", "SampleArrayDomain": "ArrayListDomain"}
#: Hints about what this plugin does not have.
OWN_HINTS = ("Representation", "RepresentationType", "PipelineIcon")


#: What this plugin has.
CLASSES = (
    "vtkBlockedVolumeReader",
    "vtkBlockedVolumeWriter",
    "vtkContourSpectrum",
    "vtkEdgeIndexReader",
    "vtkEdgeIndexWriter",
    "vtkInPlaceVolumeReader",
    "vtkStabbingContour",
    "vtkVolumeProbe",
    "vtkVolumeRegion",
    "vtkVolumeSlice",
)


def adapt(element):
    """Makes an element of the C++ plugin's XML one of this plugin's."""
    element.tag = STOCK_DOMAINS.get(element.tag, element.tag)
    widget = element.attrib.pop("panel_widget", None)
    if widget in STOCK_WIDGETS:
        element.set("panel_widget", STOCK_WIDGETS[widget])
    if element.tag == "ShowInMenu":
        element.attrib.pop("icon", None)
    for child in list(element):
        if child.tag in OWN_HINTS or (
            child.tag == "PropertyWidgetDecorator" and child.get("type") not in STOCK_DECORATORS
        ):
            element.remove(child)
        else:
            adapt(child)
            if child.tag == "ReaderFactory" and VTK_VERSION < 902 and "[" in child.get("filename_patterns", ""):
                # ParaView before 5.11 asks no reader of Python whether it can read a file that its name suits.
                del child.attrib["filename_patterns"]


def read_definitions():
    """The XML of all proxies, the properties of each class, and the endings of raw files."""
    root = ElementTree.parse(os.path.join(os.path.dirname(os.path.dirname(__file__)), "ScalableIsosurface.xml")).getroot()
    properties = {}
    parts = {proxy.get("name"): proxy for group in root for proxy in group}
    for group in list(root):
        for proxy in list(group):
            if proxy.get("class") == "vtkFileSeriesReader":  # it does not reach readers of Python
                join_series(parts, proxy)
            name = proxy.get("class")
            if name in CLASSES and group.get("name") != "internal_sources":
                proxy.set("class", f"{__package__}.{name}")
                proxy.set("si_class", "vtkSIPythonSourceProxy")
                properties.setdefault(name, [child for child in proxy if child.tag.endswith("Property")])
            else:
                group.remove(proxy)
                continue
            adapt(proxy)
            if name == "vtkStabbingContour" and proxy.find("IdTypeVectorProperty") is not None:
                propose(proxy)
            if name in ("vtkInPlaceVolumeReader", "vtkStabbingContour"):
                hints = proxy.find("Hints")
                hints = ElementTree.SubElement(proxy, "Hints") if hints is None else hints
                ElementTree.SubElement(hints, "LiveSource", interval="100")
    raw = [hint for hint in root.iter("ReaderFactory") if hint.get("file_description", "").startswith("Raw volume")]
    endings = tuple("." + ending for hint in raw for ending in hint.get("extensions").split())
    return ElementTree.tostring(root, encoding="unicode"), properties, endings


def propose(proxy):
    """Has the default of the isovalues be what the server proposes, as in the plugin in C++."""
    isovalues = next(child for child in proxy if child.get("name") == "ContourValues")
    place = list(proxy).index(isovalues)
    attributes = {"name": "Proposal", "command": "GetProposal", "information_only": "1", "number_of_elements": "1"}
    found = ElementTree.Element("DoubleVectorProperty", attributes, default_values="0", panel_visibility="never")
    ElementTree.SubElement(found, "SimpleDoubleInformationHelper")
    proxy.insert(place, found)
    isovalues.remove(isovalues.find("ArrayRangeDomain"))
    domain = ElementTree.SubElement(isovalues, "DoubleRangeDomain", name="scalar_range", default_mode="min")
    required = ElementTree.SubElement(domain, "RequiredProperties")
    ElementTree.SubElement(required, "Property", function="Range", name="Proposal")


def join_series(parts, proxy):
    """Gives a reader of series the properties of the reader of one file that it has as a part."""
    part = proxy.find("SubProxy")
    core = parts[part.find("Proxy").get("proxyname")]
    own = {child.get("name") for child in proxy}
    place = list(proxy).index(part)
    proxy.remove(part)
    for child in reversed([child for child in core if child.tag.endswith("Property")]):
        if child.get("name") not in own:
            proxy.insert(place, copy.deepcopy(child))
    proxy.set("class", core.get("class"))
    del proxy.attrib["file_name_method"]


def parse_default(element):
    """The value of a property before it is set."""
    if element.get("repeat_command") == "1":
        return {} if element.get("number_of_elements_per_command") == "2" else []
    words = element.get("default_values", "").split()
    if element.tag == "StringVectorProperty":
        return element.get("default_values", "")
    numbers = [(float if element.tag == "DoubleVectorProperty" else int)(word) for word in words]
    return numbers[0] if len(numbers) == 1 else tuple(numbers)


DEFINITIONS, PROPERTIES, RAW_EXTENSIONS = read_definitions()
