"""A real client that drives the server over standard input and output; a module's tests share one."""

from __future__ import annotations

import sys
from collections.abc import AsyncIterator

import pytest
import pytest_lsp
from lsprotocol import types as lsp
from pytest_lsp import ClientServerConfig, LanguageClient, client_capabilities


@pytest_lsp.fixture(
    scope="module", config=ClientServerConfig(server_command=[sys.executable, "-P", "-m", "scenelang", "lsp"])
)
async def client(lsp_client: LanguageClient, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[None]:
    root = tmp_path_factory.mktemp("workspace")
    lsp_client.root, lsp_client.published = root, {}

    def published(params: lsp.PublishDiagnosticsParams) -> None:
        lsp_client.published[params.uri] = params

    # in place of the client's own handler, which forgets the version of the text
    lsp_client.protocol.fm.features[lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS] = published
    parameters = lsp.InitializeParams(capabilities=client_capabilities("visual-studio-code"), root_uri=root.as_uri())
    await lsp_client.initialize_session(parameters)
    yield
    await lsp_client.shutdown_session()
