// Tables to copy and to take along as CSV.

function csv(table) {
  const field = (text) => (/[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const row = (tr) => [...tr.cells].map((cell) => field(cell.dataset.value ?? cell.textContent.trim()));
  return [...table.rows].map((tr) => row(tr).join(',')).join('\n') + '\n';
}

function addTools(table) {
  const bar = document.createElement('div');
  bar.className = 'tools';
  const button = (text, act) => {
    const made = document.createElement('button');
    made.type = 'button';
    made.textContent = text;
    made.addEventListener('click', act);
    bar.append(made);
    return made;
  };
  const copy = button('Copy', async () => {
    const text = csv(table).replace(/\n$/, '');
    try {
      await navigator.clipboard.writeText(text);
    } catch {
      getSelection().selectAllChildren(table);
      document.execCommand('copy');
    }
    copy.textContent = 'Copied';
    setTimeout(() => { copy.textContent = 'Copy'; }, 1500);
  });
  button('Download CSV', () => {
    const link = document.createElement('a');
    link.href = URL.createObjectURL(new Blob([csv(table)], { type: 'text/csv' }));
    link.download = `${table.dataset.csv}.csv`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  });
  (table.closest('.scroll') ?? table).after(bar);
}
