"""From a sentence through EDS to abstract instructions; the home of PyDelphin."""
