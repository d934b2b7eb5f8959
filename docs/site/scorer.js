// Replaces Sphinx's scores of search results: PAGES and WEIGHTS are those of tools/site_search.py.
var Scorer = {
  score([page, , , , score]) {
    const query = new URLSearchParams(window.location.search).get("q") || "";
    const stemmer = new Stemmer();
    const stems = splitQuery(query.toLowerCase()).map((word) => stemmer.stemWord(word));
    const number = PAGES.indexOf(page);
    const weights = stems.map((stem) => (WEIGHTS[stem] || {})[number] || 0);
    // Sphinx's own score decides between the headings of a page, and between other pages.
    return weights.reduce((sum, weight) => sum + weight, score / 1e12);
  },
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
