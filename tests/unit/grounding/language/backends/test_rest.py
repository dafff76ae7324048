"""The REST backend against a server on this machine."""

import json
import threading
from http.server import BaseHTTPRequestHandler, HTTPServer
from urllib.parse import parse_qs, urlparse

import pytest
from delphin.codecs import edsjson

from grounding.errors import BackendError, ConfigError
from grounding.language.backends.embedded import Embedded
from grounding.language.backends.rest import Rest
from grounding.language.config import LanguageConfig
from grounding.language.parser import Parser
from grounding.language.verbs import default_verbs
from tests.plans import written


class Answering(BaseHTTPRequestHandler):
    """Answers as a DELPH-IN web service, from the embedded grammar."""

    def do_GET(self):
        sentence = parse_qs(urlparse(self.path).query)["input"][0]
        if sentence == "break":
            self.reply(b"{nothing", status=200)
        elif sentence == "refuse":
            self.reply(b"", status=500)
        else:
            readings = Embedded(default_verbs()).readings(sentence)
            rows = [{"result-id": i, "eds": edsjson.to_dict(r)} for i, r in enumerate(readings)]
            body = {"input": sentence, "readings": len(rows), "results": rows}
            self.reply(json.dumps(body).encode(), status=200)

    def reply(self, body, *, status):
        self.send_response(status)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_):
        """Say nothing."""


@pytest.fixture(scope="module")
def server():
    """Return the address of a running server."""
    found = HTTPServer(("127.0.0.1", 0), Answering)
    thread = threading.Thread(target=found.serve_forever, daemon=True)
    thread.start()
    yield f"http://127.0.0.1:{found.server_port}/erg"
    found.shutdown()
    found.server_close()
    thread.join()


def test_a_sentence_is_parsed_at_the_server(server):
    result = Parser(Rest(LanguageConfig(server=server))).parse("put the cup on the tray")
    assert result.backend == "rest"
    assert written(result.instructions) == "place cup @ on-tray"


@pytest.mark.parametrize(("sentence", "message"), [("break", "read"), ("refuse", "500")])
def test_a_bad_answer_is_told(server, sentence, message):
    with pytest.raises(BackendError, match=message):
        Rest(LanguageConfig(server=server)).readings(sentence)


def test_a_server_that_is_not_there_is_told():
    with pytest.raises(BackendError, match="no answer"):
        Rest(LanguageConfig(server="http://127.0.0.1:9/")).readings("take the cup")


def test_an_address_is_wanted():
    with pytest.raises(ConfigError, match="--server"):
        Rest(LanguageConfig())
