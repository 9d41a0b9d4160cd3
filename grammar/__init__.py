"""Text to trees and back; knows nothing of what programs mean.

``datum`` has sources, spans and datums, ``reader`` reads text, ``ast`` parses core forms by ``core.lark``;
``concrete``, ``layout`` and ``formatter`` print; ``diagnostics`` has every code and how a mistake is shown;
``settings`` declares fields that users may give. It imports lark and nothing else.
"""
